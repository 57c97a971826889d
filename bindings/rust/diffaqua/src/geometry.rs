// SPDX-License-Identifier: MIT
//! What a design consists of: surface, cells, actuators, muscles.
use std::ptr;

use crate::{
    ActuatorInfo, Result, Side, Simulator,
    error::check,
    handle::{count, wanted},
    sys,
};

/// The isosurface of density at half its peak.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// `[n_vertices][dims]`, m.
    pub vertices: Vec<f64>,
    /// `[n_elements][dims]`: triangles, counter-clockwise seen from outside, or segments with the body to their left.
    pub elements: Vec<i32>,
}

/// The simulated cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Nodes of each `[n_active_cells][2^dims]`, corner = 4 ix + 2 iy + iz; in two dimensions 2 ix + iy.
    pub cell_nodes: Vec<i32>,
    /// Index of each in the box `[n_active_cells]`.
    pub box_index: Vec<i32>,
    /// Of each `[n_active_cells]`; 1 at the density's peak.
    pub occupancy: Vec<f64>,
}

/// The muscle fibres, one row per active cell and fibre group.
#[derive(Clone, Debug, PartialEq)]
pub struct Muscles {
    /// Index of the cell among the active ones `[n_muscles]`.
    pub cells: Vec<i32>,
    /// Signal that drives it `[n_muscles]`.
    pub signals: Vec<i32>,
    /// +1: contracts for a positive signal; -1: an antagonist `[n_muscles]`.
    pub signs: Vec<i32>,
    /// At rest `[n_muscles][dims]`.
    pub directions: Vec<f64>,
    /// Pa `[n_muscles]`.
    pub stiffness: Vec<f64>,
}

impl Simulator {
    /// (vertices, elements) of the surface of the present design.
    pub fn surface_size(&self) -> Result<(usize, usize)> {
        let (mut vertices, mut elements, none) = (0, 0, ptr::null_mut());
        // SAFETY: NULL buffers are allowed.
        check(unsafe {
            sys::dqa_simulator_surface(self.get(), none, 0, ptr::null_mut(), 0, &mut vertices, &mut elements)
        })?;
        Ok((vertices as usize, elements as usize))
    }

    /// The surface of the body, carried by the present state.
    pub fn surface(&self) -> Result<Surface> {
        let ((n_vertices, n_elements), dims) = (self.surface_size()?, self.info()?.dims);
        let mut surface = Surface { vertices: vec![0.0; n_vertices * dims], elements: vec![0; n_elements * dims] };
        let (vertices, nv) = wanted(Some(&mut surface.vertices[..]));
        let (elements, ne) = wanted(Some(&mut surface.elements[..]));
        // SAFETY: the arrays have as many elements as they say.
        check(unsafe {
            sys::dqa_simulator_surface(self.get(), vertices, nv, elements, ne, ptr::null_mut(), ptr::null_mut())
        })?;
        Ok(surface)
    }

    /// The simulated cells.
    pub fn mesh(&self) -> Result<Mesh> {
        let info = self.info()?;
        let n = info.n_active_cells;
        let mut mesh = Mesh { cell_nodes: vec![0; n << info.dims], box_index: vec![0; n], occupancy: vec![0.0; n] };
        let (nodes, n_nodes) = wanted(Some(&mut mesh.cell_nodes[..]));
        let (index, n_index) = wanted(Some(&mut mesh.box_index[..]));
        let (occupancy, n_occupancy) = wanted(Some(&mut mesh.occupancy[..]));
        // SAFETY: the arrays have as many elements as they say.
        check(unsafe { sys::dqa_simulator_mesh(self.get(), nodes, n_nodes, index, n_index, occupancy, n_occupancy) })?;
        Ok(mesh)
    }

    /// What the interpolation made of an actuator: [`Side::Both`] for caudal ones, left or right for fins.
    pub fn actuator(&self, category: i32, side: Side) -> Result<ActuatorInfo> {
        // SAFETY: the handle lives; the library writes `size` bytes.
        ActuatorInfo::ask(|out, size| unsafe {
            sys::dqa_simulator_actuator(self.get(), category, side as i32, out, size)
        })
    }

    /// The muscle fibres of the present design.
    pub fn muscles(&self) -> Result<Muscles> {
        let mut n = 0;
        let (no_index, no_number) = (ptr::null_mut(), ptr::null_mut());
        // SAFETY: NULL buffers are allowed.
        check(unsafe {
            sys::dqa_simulator_muscles(self.get(), no_index, no_index, no_index, 0, no_number, 0, no_number, 0, &mut n)
        })?;
        let (rows, dims) = (n as usize, self.info()?.dims);
        let mut muscles = Muscles {
            cells: vec![0; rows],
            signals: vec![0; rows],
            signs: vec![0; rows],
            directions: vec![0.0; rows * dims],
            stiffness: vec![0.0; rows],
        };
        let (nd, ns) = (count(&muscles.directions), count(&muscles.stiffness));
        // SAFETY: the arrays have as many elements as they say.
        check(unsafe {
            sys::dqa_simulator_muscles(
                self.get(),
                muscles.cells.as_mut_ptr(),
                muscles.signals.as_mut_ptr(),
                muscles.signs.as_mut_ptr(),
                n,
                muscles.directions.as_mut_ptr(),
                nd,
                muscles.stiffness.as_mut_ptr(),
                ns,
                ptr::null_mut(),
            )
        })?;
        Ok(muscles)
    }
}
