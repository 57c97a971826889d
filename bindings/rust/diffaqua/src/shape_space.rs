// SPDX-License-Identifier: MIT
//! The space of shapes between base meshes, outlines or images.
use std::{ffi::CString, fmt, path::Path, ptr, sync::Arc};

use crate::{
    ActuatorOptions, Answer, Error, Result, ShapeSpaceInfo, ShapeSpaceOptions, Side, SignalInfo, callback,
    error::check,
    handle::{Handle, c_name, c_path, count, index, start, text},
    sys,
};

type Space = Handle<sys::dqa_shape_space>;

fn info(space: &Space) -> Result<ShapeSpaceInfo> {
    // SAFETY: the handle lives; the library writes `size` bytes.
    ShapeSpaceInfo::ask(|out, size| unsafe { sys::dqa_shape_space_get_info(space.get(), out, size) })
}

fn actuator(space: &Space, base: usize, category: i32, side: Side) -> Result<ActuatorOptions> {
    let mut options = ActuatorOptions::new();
    // SAFETY: the handle lives; the struct says its size.
    check(unsafe {
        sys::dqa_shape_space_get_actuator(space.get(), index(base), category, side as i32, options.as_raw_mut())
    })?;
    Ok(options)
}

fn base_name(space: &Space, base: usize) -> String {
    // SAFETY: the handle lives, any number is allowed, and the string is as old as the space.
    unsafe { text(sys::dqa_shape_space_base_name(space.get(), index(base))) }
}

/// A box of cells that base shapes are added to; [`build`](Self::build) turns it into a [`ShapeSpace`].
pub struct ShapeSpaceBuilder(Space);

// SAFETY: distinct objects may be used concurrently, and one by one thread at a time.
unsafe impl Send for ShapeSpaceBuilder {}

impl ShapeSpaceBuilder {
    /// A space without bases.
    pub fn new(options: &ShapeSpaceOptions) -> Result<Self> {
        let raw = options.raw();
        // SAFETY: `raw` and the token in it live for the call.
        Space::create(sys::dqa_shape_space_free, |out| unsafe { sys::dqa_shape_space_create(&raw, out) }).map(Self)
    }

    fn add(&mut self, call: impl FnOnce(*mut sys::dqa_shape_space, *mut i32) -> sys::dqa_status) -> Result<usize> {
        let mut base = 0;
        check(call(self.0.get(), &mut base))?;
        Ok(base as usize)
    }

    /// Adds a closed triangle mesh, any unit; returns the index of the base. It is scaled to fit the box.
    /// [`Status::Mesh`](crate::Status::Mesh) for one that is open, inconsistently oriented or not finite.
    pub fn add_mesh(&mut self, name: &str, vertices: &[[f64; 3]], triangles: &[[i32; 3]]) -> Result<usize> {
        let name = c_name("name", name)?;
        let (points, corners) = (start(vertices.as_flattened()), start(triangles.as_flattened()));
        // SAFETY: the arrays have as many rows as they say and live for the call.
        self.add(|space, base| unsafe {
            let (rows, elements) = (count(vertices), count(triangles));
            sys::dqa_shape_space_add_mesh(space, name.as_ptr(), points, rows, corners, elements, base)
        })
    }

    /// The same from an STL, OBJ or PLY file; the base is named after the file. [`Status::Io`](crate::Status::Io) and
    /// [`Status::File`](crate::Status::File) where it cannot be read.
    pub fn add_mesh_file(&mut self, path: impl AsRef<Path>) -> Result<usize> {
        let path = c_path(path.as_ref())?;
        // SAFETY: a C string that lives for the call.
        self.add(|space, base| unsafe { sys::dqa_shape_space_add_mesh_file(space, path.as_ptr(), base) })
    }

    /// Adds covered fractions in [0, 1], `[cells_x][cells_y][cells_z]`.
    pub fn add_density(&mut self, name: &str, cells: &[f64]) -> Result<usize> {
        let name = c_name("name", name)?;
        // SAFETY: the array has as many elements as it says.
        self.add(|space, base| unsafe {
            sys::dqa_shape_space_add_density(space, name.as_ptr(), start(cells), count(cells), base)
        })
    }

    /// Adds a closed simple polygon of corners (x, y), any unit, to a space of two dimensions.
    pub fn add_polygon(&mut self, name: &str, corners: &[[f64; 2]]) -> Result<usize> {
        let name = c_name("name", name)?;
        let points = start(corners.as_flattened());
        // SAFETY: the array has as many rows as it says.
        self.add(|space, base| unsafe {
            sys::dqa_shape_space_add_polygon(space, name.as_ptr(), points, count(corners), base)
        })
    }

    /// Adds grey values in [0, 1] (1: body) `[n_rows][n_columns]`, the first row on top, the swimmer looking to the
    /// right, to a space of two dimensions.
    pub fn add_image(&mut self, name: &str, pixels: &[f64], n_rows: usize, n_columns: usize) -> Result<usize> {
        let name = c_name("name", name)?;
        if n_rows.checked_mul(n_columns) != Some(pixels.len()) {
            let (expected, got) = (format!("{n_rows} x {n_columns}"), pixels.len());
            return Err(Error::argument(format!("pixels: expected {expected} elements, got {got}")));
        }
        // SAFETY: the array has rows times columns elements.
        self.add(|space, base| unsafe {
            let (rows, columns) = (index(n_rows), index(n_columns));
            sys::dqa_shape_space_add_image(space, name.as_ptr(), start(pixels), rows, columns, base)
        })
    }

    /// Gives a base an actuator; bases without one get theirs from their geometry. Needs the option `cell_size`.
    pub fn add_actuator(&mut self, base: usize, options: &ActuatorOptions) -> Result<()> {
        // SAFETY: the struct lives for the call.
        check(unsafe { sys::dqa_shape_space_add_actuator(self.0.get(), index(base), &options.raw()) })
    }

    /// The actuator that a base was given.
    pub fn actuator(&self, base: usize, category: i32, side: Side) -> Result<ActuatorOptions> {
        actuator(&self.0, base, category, side)
    }

    /// Sizes of the space.
    pub fn info(&self) -> Result<ShapeSpaceInfo> {
        info(&self.0)
    }

    /// Name of a base, "" when there is no such base.
    pub fn base_name(&self, base: usize) -> String {
        base_name(&self.0, base)
    }

    /// Freezes the space: base densities, cell size, automatic actuators, sensor axis.
    pub fn build(self) -> Result<ShapeSpace, Unbuilt> {
        self.build_with(|_, _| ())
    }

    /// The same with a report of (done, total).
    pub fn build_with<A: Answer>(self, progress: impl FnMut(usize, usize) -> A) -> Result<ShapeSpace, Unbuilt> {
        // SAFETY: the progress lives for the call.
        let built = callback::with_progress(progress, |report, data| unsafe {
            sys::dqa_shape_space_build(self.0.get(), report, data)
        });
        match built {
            Ok(()) => Ok(ShapeSpace::new(self.0)),
            Err(error) => Err(Unbuilt { error, builder: self }),
        }
    }
}

/// A space that could not be built, or whose building was stopped: it may be added to and built again. `?` makes an
/// [`Error`] of it.
#[derive(Debug)]
pub struct Unbuilt {
    /// Why.
    pub error: Error,
    /// As it was before.
    pub builder: ShapeSpaceBuilder,
}

impl fmt::Display for Unbuilt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.error.fmt(f)
    }
}

impl std::error::Error for Unbuilt {}

impl From<Unbuilt> for Error {
    fn from(unbuilt: Unbuilt) -> Self {
        unbuilt.error
    }
}

/// A built space: base shapes, their actuators, and the Wasserstein interpolation between them. Read-only; clones are
/// the same space.
#[derive(Clone)]
pub struct ShapeSpace(Arc<Built>);

struct Built(Space);

// SAFETY: a built shape space is read-only and may be shared between threads, and the last clone frees it.
unsafe impl Send for Built {}
// SAFETY: as above.
unsafe impl Sync for Built {}

impl ShapeSpace {
    fn new(space: Space) -> Self {
        ShapeSpace(Arc::new(Built(space)))
    }

    pub(crate) fn get(&self) -> *mut sys::dqa_shape_space {
        self.0.0.get()
    }

    /// The built space of a file that [`save`](Self::save) wrote; [`Status::File`](crate::Status::File) for any other.
    pub fn load(path: impl AsRef<Path>) -> Result<Self> {
        let path: CString = c_path(path.as_ref())?;
        // SAFETY: a C string that lives for the call.
        let load = |out: *mut *mut sys::dqa_shape_space| unsafe { sys::dqa_shape_space_load(path.as_ptr(), out) };
        Space::create(sys::dqa_shape_space_free, load).map(ShapeSpace::new)
    }

    /// Writes it to a file, whole or not at all; read back it has the same bits.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<()> {
        let path = c_path(path.as_ref())?;
        // SAFETY: a C string that lives for the call.
        check(unsafe { sys::dqa_shape_space_save(self.get(), path.as_ptr()) })
    }

    /// Sizes of the space.
    pub fn info(&self) -> Result<ShapeSpaceInfo> {
        info(&self.0.0)
    }

    /// Name of a base, "" when there is no such base.
    pub fn base_name(&self, base: usize) -> String {
        base_name(&self.0.0, base)
    }

    /// The actuator of a base, also an automatic one: [`Side::Both`] for caudal ones, left or right for fins.
    pub fn actuator(&self, base: usize, category: i32, side: Side) -> Result<ActuatorOptions> {
        actuator(&self.0.0, base, category, side)
    }

    /// What actuation signal `signal` in [0, n_signals) drives.
    pub fn signal(&self, signal: usize) -> Result<SignalInfo> {
        // SAFETY: the handle lives; the library writes `size` bytes.
        SignalInfo::ask(|out, size| unsafe { sys::dqa_shape_space_signal(self.get(), index(signal), out, size) })
    }

    /// Covered fractions of a base, `[cells_x][cells_y][cells_z]`.
    pub fn base(&self, base: usize) -> Result<Vec<f64>> {
        let mut cells = vec![0.0; self.info()?.n_cells];
        // SAFETY: the array has as many elements as it says.
        check(unsafe { sys::dqa_shape_space_get_base(self.get(), index(base), cells.as_mut_ptr(), count(&cells)) })?;
        Ok(cells)
    }

    /// Density of the barycentre divided by its peak, `[cells_x][cells_y][cells_z]`; the body is where it exceeds 1/2.
    /// weights `[n_bases]` on the simplex. [`Status::NotConverged`](crate::Status::NotConverged) after the options'
    /// max_iterations.
    pub fn density(&self, weights: &[f64]) -> Result<Vec<f64>> {
        let mut density = vec![0.0; self.info()?.n_cells];
        self.density_into(weights, &mut density)?;
        Ok(density)
    }

    /// The same into an array of the caller's.
    pub fn density_into(&self, weights: &[f64], density: &mut [f64]) -> Result<()> {
        let (out, n) = (density.as_mut_ptr(), count(density));
        // SAFETY: the arrays have as many elements as they say.
        check(unsafe { sys::dqa_shape_space_density(self.get(), start(weights), count(weights), out, n) })
    }

    /// Pullback of [`density`](Self::density): the mean-free gradient `[n_bases]` by the weights of a loss whose
    /// gradient by the density is density_bar `[cells_x][cells_y][cells_z]`.
    pub fn pullback(&self, weights: &[f64], density_bar: &[f64]) -> Result<Vec<f64>> {
        let mut bar = vec![0.0; weights.len()];
        let out = if bar.is_empty() { ptr::null_mut() } else { bar.as_mut_ptr() };
        let (m, n) = (count(weights), count(density_bar));
        // SAFETY: the arrays have as many elements as they say, the output as many as the weights.
        check(unsafe { sys::dqa_shape_space_pullback(self.get(), start(weights), m, start(density_bar), n, out) })?;
        Ok(bar)
    }
}

impl fmt::Debug for ShapeSpaceBuilder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("ShapeSpaceBuilder").field(&self.info()).finish()
    }
}

impl fmt::Debug for ShapeSpace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("ShapeSpace").field(&self.info()).finish()
    }
}
