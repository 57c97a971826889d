// SPDX-License-Identifier: MIT
// Made by bindgen from capi/diffaqua.h, where everything is explained: see bindings/rust/bindgen.

pub const DQA_VERSION_MAJOR: i32 = 0;
pub const DQA_VERSION_MINOR: i32 = 1;
pub const DQA_VERSION_PATCH: i32 = 0;
pub const DQA_ABI_VERSION: i32 = 0;
pub const DQA_SUCCESS: i32 = 0;
pub const DQA_ERROR_ARGUMENT: i32 = -1;
pub const DQA_ERROR_STATE: i32 = -2;
pub const DQA_ERROR_FILE: i32 = -3;
pub const DQA_ERROR_IO: i32 = -4;
pub const DQA_ERROR_MESH: i32 = -5;
pub const DQA_ERROR_MEMORY: i32 = -6;
pub const DQA_ERROR_UNSUPPORTED: i32 = -7;
pub const DQA_NOT_CONVERGED: i32 = -8;
pub const DQA_DIVERGED: i32 = -9;
pub const DQA_CANCELLED: i32 = -10;
pub const DQA_ERROR_INTERNAL: i32 = -11;
pub const DQA_LOG_ERROR: i32 = 1;
pub const DQA_LOG_WARNING: i32 = 2;
pub const DQA_LOG_INFO: i32 = 3;
pub const DQA_LOG_DEBUG: i32 = 4;
pub const DQA_PEAK_SMOOTH: i32 = 0;
pub const DQA_PEAK_PAPER: i32 = 1;
pub const DQA_UP_AUTO: i32 = 0;
pub const DQA_UP_Z: i32 = 1;
pub const DQA_UP_Y: i32 = 2;
pub const DQA_INTERPOLATION_LINEAR: i32 = 0;
pub const DQA_INTERPOLATION_BURES: i32 = 1;
pub const DQA_ACTUATOR_CAUDAL: i32 = 0;
pub const DQA_ACTUATOR_FINS: i32 = 1;
pub const DQA_SIDE_BOTH: i32 = 0;
pub const DQA_SIDE_LEFT: i32 = 1;
pub const DQA_SIDE_RIGHT: i32 = 2;
pub const DQA_METHOD_NEWTON_PCG: i32 = 0;
pub const DQA_METHOD_NEWTON_DIRECT: i32 = 1;
pub const DQA_METHOD_PROJECTIVE: i32 = 2;
pub const DQA_PRECONDITIONER_MULTILEVEL: i32 = 0;
pub const DQA_PRECONDITIONER_FACTOR: i32 = 1;
pub const DQA_PRECISION_SINGLE: i32 = 0;
pub const DQA_PRECISION_DOUBLE: i32 = 1;
pub const DQA_INTEGRATOR_IMPLICIT_EULER: i32 = 0;
pub const DQA_INTEGRATOR_BDF2: i32 = 1;
pub const DQA_MATERIAL_COROTATED: i32 = 0;
pub const DQA_MATERIAL_COROTATED_VOLUME: i32 = 1;
pub const DQA_MATERIAL_NEO_HOOKEAN: i32 = 2;
pub const DQA_QUADRATURE_FULL: i32 = 0;
pub const DQA_QUADRATURE_REDUCED: i32 = 1;
pub const DQA_WATER_NONE: i32 = 0;
pub const DQA_WATER_IMPLICIT: i32 = 1;
pub const DQA_WATER_EXPLICIT: i32 = 2;
pub const DQA_FACES_BOTH: i32 = 0;
pub const DQA_FACES_WINDWARD: i32 = 1;
pub const DQA_CONTROLLER_SINUSOID: i32 = 0;
pub const DQA_CONTROLLER_MLP: i32 = 1;
pub const DQA_CONTROLLER_CALLBACK: i32 = 2;
pub const DQA_OBJECTIVE_TRAVEL: i32 = 0;
pub const DQA_OBJECTIVE_POSITION_KEEPING: i32 = 1;
pub const DQA_OBJECTIVE_EFFICIENCY: i32 = 2;
pub const DQA_OBJECTIVE_EFFORT: i32 = 3;
pub const DQA_OBJECTIVE_PATH: i32 = 4;
pub const DQA_SEED_POSITION: i32 = 0;
pub const DQA_SEED_VELOCITY: i32 = 1;
pub const DQA_WRT_WEIGHTS: i32 = 0;
pub const DQA_WRT_CONTROL: i32 = 1;
pub const DQA_WRT_ACTUATION: i32 = 2;
pub const DQA_WRT_INITIAL_POSITION: i32 = 3;
pub const DQA_WRT_INITIAL_VELOCITY: i32 = 4;
pub const DQA_WRT_WATER: i32 = 5;
pub const DQA_WRT_CURRENT: i32 = 6;
pub const DQA_WRT_CURRENT_TABLE: i32 = 7;
pub const DQA_WRT_YOUNGS_MODULUS: i32 = 8;
pub const DQA_WRT_MUSCLE_STIFFNESS: i32 = 9;
pub const DQA_WRT_MATERIAL: i32 = 10;
pub const DQA_WRT_LAME: i32 = 11;
pub type dqa_status = i32;
pub type dqa_log_handler = ::core::option::Option<
    unsafe extern "C" fn(
        level: i32,
        message: *const core::ffi::c_char,
        user_data: *mut core::ffi::c_void,
    ),
>;
pub type dqa_progress = ::core::option::Option<
    unsafe extern "C" fn(done: i64, total: i64, user_data: *mut core::ffi::c_void) -> i32,
>;
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct dqa_cancel_token {
    _unused: [u8; 0],
}
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct dqa_shape_space {
    _unused: [u8; 0],
}
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct dqa_shape_space_options {
    pub struct_size: u32,
    pub flags: u32,
    pub dims: i32,
    pub cells_x: i32,
    pub cells_y: i32,
    pub cells_z: i32,
    pub margin: i32,
    pub margin_across: i32,
    pub up: i32,
    pub subsamples: i32,
    pub peak: i32,
    pub max_iterations: i32,
    pub threads: i32,
    pub padding: i32,
    pub body_length: f64,
    pub cell_size: f64,
    pub sigma: f64,
    pub tolerance: f64,
    pub cancel: *mut dqa_cancel_token,
    pub interpolation: i32,
    pub automatic_fins: i32,
    pub refinement: i64,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    [
        "Size of dqa_shape_space_options",
    ][::core::mem::size_of::<dqa_shape_space_options>() - 112usize];
    [
        "Alignment of dqa_shape_space_options",
    ][::core::mem::align_of::<dqa_shape_space_options>() - 8usize];
    [
        "Offset of field: dqa_shape_space_options::struct_size",
    ][::core::mem::offset_of!(dqa_shape_space_options, struct_size) - 0usize];
    [
        "Offset of field: dqa_shape_space_options::flags",
    ][::core::mem::offset_of!(dqa_shape_space_options, flags) - 4usize];
    [
        "Offset of field: dqa_shape_space_options::dims",
    ][::core::mem::offset_of!(dqa_shape_space_options, dims) - 8usize];
    [
        "Offset of field: dqa_shape_space_options::cells_x",
    ][::core::mem::offset_of!(dqa_shape_space_options, cells_x) - 12usize];
    [
        "Offset of field: dqa_shape_space_options::cells_y",
    ][::core::mem::offset_of!(dqa_shape_space_options, cells_y) - 16usize];
    [
        "Offset of field: dqa_shape_space_options::cells_z",
    ][::core::mem::offset_of!(dqa_shape_space_options, cells_z) - 20usize];
    [
        "Offset of field: dqa_shape_space_options::margin",
    ][::core::mem::offset_of!(dqa_shape_space_options, margin) - 24usize];
    [
        "Offset of field: dqa_shape_space_options::margin_across",
    ][::core::mem::offset_of!(dqa_shape_space_options, margin_across) - 28usize];
    [
        "Offset of field: dqa_shape_space_options::up",
    ][::core::mem::offset_of!(dqa_shape_space_options, up) - 32usize];
    [
        "Offset of field: dqa_shape_space_options::subsamples",
    ][::core::mem::offset_of!(dqa_shape_space_options, subsamples) - 36usize];
    [
        "Offset of field: dqa_shape_space_options::peak",
    ][::core::mem::offset_of!(dqa_shape_space_options, peak) - 40usize];
    [
        "Offset of field: dqa_shape_space_options::max_iterations",
    ][::core::mem::offset_of!(dqa_shape_space_options, max_iterations) - 44usize];
    [
        "Offset of field: dqa_shape_space_options::threads",
    ][::core::mem::offset_of!(dqa_shape_space_options, threads) - 48usize];
    [
        "Offset of field: dqa_shape_space_options::padding",
    ][::core::mem::offset_of!(dqa_shape_space_options, padding) - 52usize];
    [
        "Offset of field: dqa_shape_space_options::body_length",
    ][::core::mem::offset_of!(dqa_shape_space_options, body_length) - 56usize];
    [
        "Offset of field: dqa_shape_space_options::cell_size",
    ][::core::mem::offset_of!(dqa_shape_space_options, cell_size) - 64usize];
    [
        "Offset of field: dqa_shape_space_options::sigma",
    ][::core::mem::offset_of!(dqa_shape_space_options, sigma) - 72usize];
    [
        "Offset of field: dqa_shape_space_options::tolerance",
    ][::core::mem::offset_of!(dqa_shape_space_options, tolerance) - 80usize];
    [
        "Offset of field: dqa_shape_space_options::cancel",
    ][::core::mem::offset_of!(dqa_shape_space_options, cancel) - 88usize];
    [
        "Offset of field: dqa_shape_space_options::interpolation",
    ][::core::mem::offset_of!(dqa_shape_space_options, interpolation) - 96usize];
    [
        "Offset of field: dqa_shape_space_options::automatic_fins",
    ][::core::mem::offset_of!(dqa_shape_space_options, automatic_fins) - 100usize];
    [
        "Offset of field: dqa_shape_space_options::refinement",
    ][::core::mem::offset_of!(dqa_shape_space_options, refinement) - 104usize];
};
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct dqa_actuator_options {
    pub struct_size: u32,
    pub flags: u32,
    pub category: i32,
    pub kind: i32,
    pub mean: [f64; 3usize],
    pub variance: [f64; 3usize],
    pub euler: [f64; 3usize],
    pub side: i32,
    pub layers: i32,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    [
        "Size of dqa_actuator_options",
    ][::core::mem::size_of::<dqa_actuator_options>() - 96usize];
    [
        "Alignment of dqa_actuator_options",
    ][::core::mem::align_of::<dqa_actuator_options>() - 8usize];
    [
        "Offset of field: dqa_actuator_options::struct_size",
    ][::core::mem::offset_of!(dqa_actuator_options, struct_size) - 0usize];
    [
        "Offset of field: dqa_actuator_options::flags",
    ][::core::mem::offset_of!(dqa_actuator_options, flags) - 4usize];
    [
        "Offset of field: dqa_actuator_options::category",
    ][::core::mem::offset_of!(dqa_actuator_options, category) - 8usize];
    [
        "Offset of field: dqa_actuator_options::kind",
    ][::core::mem::offset_of!(dqa_actuator_options, kind) - 12usize];
    [
        "Offset of field: dqa_actuator_options::mean",
    ][::core::mem::offset_of!(dqa_actuator_options, mean) - 16usize];
    [
        "Offset of field: dqa_actuator_options::variance",
    ][::core::mem::offset_of!(dqa_actuator_options, variance) - 40usize];
    [
        "Offset of field: dqa_actuator_options::euler",
    ][::core::mem::offset_of!(dqa_actuator_options, euler) - 64usize];
    [
        "Offset of field: dqa_actuator_options::side",
    ][::core::mem::offset_of!(dqa_actuator_options, side) - 88usize];
    [
        "Offset of field: dqa_actuator_options::layers",
    ][::core::mem::offset_of!(dqa_actuator_options, layers) - 92usize];
};
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct dqa_shape_space_info {
    pub struct_size: u32,
    pub dims: i32,
    pub cells_x: i32,
    pub cells_y: i32,
    pub cells_z: i32,
    pub n_bases: i32,
    pub n_signals: i32,
    pub is_built: i32,
    pub n_cells: i64,
    pub cell_size: f64,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    [
        "Size of dqa_shape_space_info",
    ][::core::mem::size_of::<dqa_shape_space_info>() - 48usize];
    [
        "Alignment of dqa_shape_space_info",
    ][::core::mem::align_of::<dqa_shape_space_info>() - 8usize];
    [
        "Offset of field: dqa_shape_space_info::struct_size",
    ][::core::mem::offset_of!(dqa_shape_space_info, struct_size) - 0usize];
    [
        "Offset of field: dqa_shape_space_info::dims",
    ][::core::mem::offset_of!(dqa_shape_space_info, dims) - 4usize];
    [
        "Offset of field: dqa_shape_space_info::cells_x",
    ][::core::mem::offset_of!(dqa_shape_space_info, cells_x) - 8usize];
    [
        "Offset of field: dqa_shape_space_info::cells_y",
    ][::core::mem::offset_of!(dqa_shape_space_info, cells_y) - 12usize];
    [
        "Offset of field: dqa_shape_space_info::cells_z",
    ][::core::mem::offset_of!(dqa_shape_space_info, cells_z) - 16usize];
    [
        "Offset of field: dqa_shape_space_info::n_bases",
    ][::core::mem::offset_of!(dqa_shape_space_info, n_bases) - 20usize];
    [
        "Offset of field: dqa_shape_space_info::n_signals",
    ][::core::mem::offset_of!(dqa_shape_space_info, n_signals) - 24usize];
    [
        "Offset of field: dqa_shape_space_info::is_built",
    ][::core::mem::offset_of!(dqa_shape_space_info, is_built) - 28usize];
    [
        "Offset of field: dqa_shape_space_info::n_cells",
    ][::core::mem::offset_of!(dqa_shape_space_info, n_cells) - 32usize];
    [
        "Offset of field: dqa_shape_space_info::cell_size",
    ][::core::mem::offset_of!(dqa_shape_space_info, cell_size) - 40usize];
};
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct dqa_signal_info {
    pub struct_size: u32,
    pub category: i32,
    pub kind: i32,
    pub layer: i32,
    pub group: i32,
    pub padding: i32,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of dqa_signal_info"][::core::mem::size_of::<dqa_signal_info>() - 24usize];
    [
        "Alignment of dqa_signal_info",
    ][::core::mem::align_of::<dqa_signal_info>() - 4usize];
    [
        "Offset of field: dqa_signal_info::struct_size",
    ][::core::mem::offset_of!(dqa_signal_info, struct_size) - 0usize];
    [
        "Offset of field: dqa_signal_info::category",
    ][::core::mem::offset_of!(dqa_signal_info, category) - 4usize];
    [
        "Offset of field: dqa_signal_info::kind",
    ][::core::mem::offset_of!(dqa_signal_info, kind) - 8usize];
    [
        "Offset of field: dqa_signal_info::layer",
    ][::core::mem::offset_of!(dqa_signal_info, layer) - 12usize];
    [
        "Offset of field: dqa_signal_info::group",
    ][::core::mem::offset_of!(dqa_signal_info, group) - 16usize];
    [
        "Offset of field: dqa_signal_info::padding",
    ][::core::mem::offset_of!(dqa_signal_info, padding) - 20usize];
};
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct dqa_simulator {
    _unused: [u8; 0],
}
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct dqa_controller {
    _unused: [u8; 0],
}
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct dqa_tape {
    _unused: [u8; 0],
}
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct dqa_adjoint {
    _unused: [u8; 0],
}
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct dqa_simulator_options {
    pub struct_size: u32,
    pub flags: u32,
    pub threads: i32,
    pub method: i32,
    pub water: i32,
    pub max_newton: i32,
    pub max_linear: i32,
    pub instruction_set: i32,
    pub integrator: i32,
    pub material: i32,
    pub planar: i32,
    pub preconditioner: i32,
    pub time_step: f64,
    pub young_modulus: f64,
    pub poisson_ratio: f64,
    pub density: f64,
    pub muscle_stiffness: f64,
    pub contraction: f64,
    pub threshold: f64,
    pub occupancy_floor: f64,
    pub tolerance: f64,
    pub adjoint_tolerance: f64,
    pub water_density: f64,
    pub current: [f64; 3usize],
    pub drag_coefficients: [f64; 4usize],
    pub thrust_coefficients: [f64; 4usize],
    pub speed_smoothing: f64,
    pub angle_smoothing: f64,
    pub surface_smoothing: f64,
    pub cancel: *mut dqa_cancel_token,
    pub water_faces: i32,
    pub linear_precision: i32,
    pub quadrature: i32,
    pub padding: i32,
    pub max_products: i64,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    [
        "Size of dqa_simulator_options",
    ][::core::mem::size_of::<dqa_simulator_options>() - 280usize];
    [
        "Alignment of dqa_simulator_options",
    ][::core::mem::align_of::<dqa_simulator_options>() - 8usize];
    [
        "Offset of field: dqa_simulator_options::struct_size",
    ][::core::mem::offset_of!(dqa_simulator_options, struct_size) - 0usize];
    [
        "Offset of field: dqa_simulator_options::flags",
    ][::core::mem::offset_of!(dqa_simulator_options, flags) - 4usize];
    [
        "Offset of field: dqa_simulator_options::threads",
    ][::core::mem::offset_of!(dqa_simulator_options, threads) - 8usize];
    [
        "Offset of field: dqa_simulator_options::method",
    ][::core::mem::offset_of!(dqa_simulator_options, method) - 12usize];
    [
        "Offset of field: dqa_simulator_options::water",
    ][::core::mem::offset_of!(dqa_simulator_options, water) - 16usize];
    [
        "Offset of field: dqa_simulator_options::max_newton",
    ][::core::mem::offset_of!(dqa_simulator_options, max_newton) - 20usize];
    [
        "Offset of field: dqa_simulator_options::max_linear",
    ][::core::mem::offset_of!(dqa_simulator_options, max_linear) - 24usize];
    [
        "Offset of field: dqa_simulator_options::instruction_set",
    ][::core::mem::offset_of!(dqa_simulator_options, instruction_set) - 28usize];
    [
        "Offset of field: dqa_simulator_options::integrator",
    ][::core::mem::offset_of!(dqa_simulator_options, integrator) - 32usize];
    [
        "Offset of field: dqa_simulator_options::material",
    ][::core::mem::offset_of!(dqa_simulator_options, material) - 36usize];
    [
        "Offset of field: dqa_simulator_options::planar",
    ][::core::mem::offset_of!(dqa_simulator_options, planar) - 40usize];
    [
        "Offset of field: dqa_simulator_options::preconditioner",
    ][::core::mem::offset_of!(dqa_simulator_options, preconditioner) - 44usize];
    [
        "Offset of field: dqa_simulator_options::time_step",
    ][::core::mem::offset_of!(dqa_simulator_options, time_step) - 48usize];
    [
        "Offset of field: dqa_simulator_options::young_modulus",
    ][::core::mem::offset_of!(dqa_simulator_options, young_modulus) - 56usize];
    [
        "Offset of field: dqa_simulator_options::poisson_ratio",
    ][::core::mem::offset_of!(dqa_simulator_options, poisson_ratio) - 64usize];
    [
        "Offset of field: dqa_simulator_options::density",
    ][::core::mem::offset_of!(dqa_simulator_options, density) - 72usize];
    [
        "Offset of field: dqa_simulator_options::muscle_stiffness",
    ][::core::mem::offset_of!(dqa_simulator_options, muscle_stiffness) - 80usize];
    [
        "Offset of field: dqa_simulator_options::contraction",
    ][::core::mem::offset_of!(dqa_simulator_options, contraction) - 88usize];
    [
        "Offset of field: dqa_simulator_options::threshold",
    ][::core::mem::offset_of!(dqa_simulator_options, threshold) - 96usize];
    [
        "Offset of field: dqa_simulator_options::occupancy_floor",
    ][::core::mem::offset_of!(dqa_simulator_options, occupancy_floor) - 104usize];
    [
        "Offset of field: dqa_simulator_options::tolerance",
    ][::core::mem::offset_of!(dqa_simulator_options, tolerance) - 112usize];
    [
        "Offset of field: dqa_simulator_options::adjoint_tolerance",
    ][::core::mem::offset_of!(dqa_simulator_options, adjoint_tolerance) - 120usize];
    [
        "Offset of field: dqa_simulator_options::water_density",
    ][::core::mem::offset_of!(dqa_simulator_options, water_density) - 128usize];
    [
        "Offset of field: dqa_simulator_options::current",
    ][::core::mem::offset_of!(dqa_simulator_options, current) - 136usize];
    [
        "Offset of field: dqa_simulator_options::drag_coefficients",
    ][::core::mem::offset_of!(dqa_simulator_options, drag_coefficients) - 160usize];
    [
        "Offset of field: dqa_simulator_options::thrust_coefficients",
    ][::core::mem::offset_of!(dqa_simulator_options, thrust_coefficients) - 192usize];
    [
        "Offset of field: dqa_simulator_options::speed_smoothing",
    ][::core::mem::offset_of!(dqa_simulator_options, speed_smoothing) - 224usize];
    [
        "Offset of field: dqa_simulator_options::angle_smoothing",
    ][::core::mem::offset_of!(dqa_simulator_options, angle_smoothing) - 232usize];
    [
        "Offset of field: dqa_simulator_options::surface_smoothing",
    ][::core::mem::offset_of!(dqa_simulator_options, surface_smoothing) - 240usize];
    [
        "Offset of field: dqa_simulator_options::cancel",
    ][::core::mem::offset_of!(dqa_simulator_options, cancel) - 248usize];
    [
        "Offset of field: dqa_simulator_options::water_faces",
    ][::core::mem::offset_of!(dqa_simulator_options, water_faces) - 256usize];
    [
        "Offset of field: dqa_simulator_options::linear_precision",
    ][::core::mem::offset_of!(dqa_simulator_options, linear_precision) - 260usize];
    [
        "Offset of field: dqa_simulator_options::quadrature",
    ][::core::mem::offset_of!(dqa_simulator_options, quadrature) - 264usize];
    [
        "Offset of field: dqa_simulator_options::padding",
    ][::core::mem::offset_of!(dqa_simulator_options, padding) - 268usize];
    [
        "Offset of field: dqa_simulator_options::max_products",
    ][::core::mem::offset_of!(dqa_simulator_options, max_products) - 272usize];
};
pub type dqa_current = ::core::option::Option<
    unsafe extern "C" fn(
        time: f64,
        current: *mut f64,
        user_data: *mut core::ffi::c_void,
    ) -> i32,
>;
pub type dqa_current_pullback = ::core::option::Option<
    unsafe extern "C" fn(
        time: f64,
        current_bar: *const f64,
        user_data: *mut core::ffi::c_void,
    ) -> i32,
>;
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct dqa_simulator_info {
    pub struct_size: u32,
    pub dims: i32,
    pub n_bases: i32,
    pub n_signals: i32,
    pub n_sensors: i32,
    pub has_design: i32,
    pub n_nodes: i64,
    pub n_active_cells: i64,
    pub n_body_cells: i64,
    pub n_faces: i64,
    pub n_muscle_cells: i64,
    pub factor_entries: i64,
    pub steps: i64,
    pub newton_iterations: i64,
    pub linear_iterations: i64,
    pub adjoint_iterations: i64,
    pub time: f64,
    pub total_mass: f64,
    pub volume: f64,
    pub cell_size: f64,
    pub last_residual: f64,
    pub setup_seconds: f64,
    pub barycenter_seconds: f64,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    [
        "Size of dqa_simulator_info",
    ][::core::mem::size_of::<dqa_simulator_info>() - 160usize];
    [
        "Alignment of dqa_simulator_info",
    ][::core::mem::align_of::<dqa_simulator_info>() - 8usize];
    [
        "Offset of field: dqa_simulator_info::struct_size",
    ][::core::mem::offset_of!(dqa_simulator_info, struct_size) - 0usize];
    [
        "Offset of field: dqa_simulator_info::dims",
    ][::core::mem::offset_of!(dqa_simulator_info, dims) - 4usize];
    [
        "Offset of field: dqa_simulator_info::n_bases",
    ][::core::mem::offset_of!(dqa_simulator_info, n_bases) - 8usize];
    [
        "Offset of field: dqa_simulator_info::n_signals",
    ][::core::mem::offset_of!(dqa_simulator_info, n_signals) - 12usize];
    [
        "Offset of field: dqa_simulator_info::n_sensors",
    ][::core::mem::offset_of!(dqa_simulator_info, n_sensors) - 16usize];
    [
        "Offset of field: dqa_simulator_info::has_design",
    ][::core::mem::offset_of!(dqa_simulator_info, has_design) - 20usize];
    [
        "Offset of field: dqa_simulator_info::n_nodes",
    ][::core::mem::offset_of!(dqa_simulator_info, n_nodes) - 24usize];
    [
        "Offset of field: dqa_simulator_info::n_active_cells",
    ][::core::mem::offset_of!(dqa_simulator_info, n_active_cells) - 32usize];
    [
        "Offset of field: dqa_simulator_info::n_body_cells",
    ][::core::mem::offset_of!(dqa_simulator_info, n_body_cells) - 40usize];
    [
        "Offset of field: dqa_simulator_info::n_faces",
    ][::core::mem::offset_of!(dqa_simulator_info, n_faces) - 48usize];
    [
        "Offset of field: dqa_simulator_info::n_muscle_cells",
    ][::core::mem::offset_of!(dqa_simulator_info, n_muscle_cells) - 56usize];
    [
        "Offset of field: dqa_simulator_info::factor_entries",
    ][::core::mem::offset_of!(dqa_simulator_info, factor_entries) - 64usize];
    [
        "Offset of field: dqa_simulator_info::steps",
    ][::core::mem::offset_of!(dqa_simulator_info, steps) - 72usize];
    [
        "Offset of field: dqa_simulator_info::newton_iterations",
    ][::core::mem::offset_of!(dqa_simulator_info, newton_iterations) - 80usize];
    [
        "Offset of field: dqa_simulator_info::linear_iterations",
    ][::core::mem::offset_of!(dqa_simulator_info, linear_iterations) - 88usize];
    [
        "Offset of field: dqa_simulator_info::adjoint_iterations",
    ][::core::mem::offset_of!(dqa_simulator_info, adjoint_iterations) - 96usize];
    [
        "Offset of field: dqa_simulator_info::time",
    ][::core::mem::offset_of!(dqa_simulator_info, time) - 104usize];
    [
        "Offset of field: dqa_simulator_info::total_mass",
    ][::core::mem::offset_of!(dqa_simulator_info, total_mass) - 112usize];
    [
        "Offset of field: dqa_simulator_info::volume",
    ][::core::mem::offset_of!(dqa_simulator_info, volume) - 120usize];
    [
        "Offset of field: dqa_simulator_info::cell_size",
    ][::core::mem::offset_of!(dqa_simulator_info, cell_size) - 128usize];
    [
        "Offset of field: dqa_simulator_info::last_residual",
    ][::core::mem::offset_of!(dqa_simulator_info, last_residual) - 136usize];
    [
        "Offset of field: dqa_simulator_info::setup_seconds",
    ][::core::mem::offset_of!(dqa_simulator_info, setup_seconds) - 144usize];
    [
        "Offset of field: dqa_simulator_info::barycenter_seconds",
    ][::core::mem::offset_of!(dqa_simulator_info, barycenter_seconds) - 152usize];
};
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct dqa_actuator_info {
    pub struct_size: u32,
    pub category: i32,
    pub kind: i32,
    pub side: i32,
    pub layers: i32,
    pub n_signals: i32,
    pub first_signal: i32,
    pub padding: i32,
    pub mean: [f64; 3usize],
    pub covariance: [f64; 9usize],
    pub half: [f64; 3usize],
    pub normal: [f64; 9usize],
    pub edge: [f64; 9usize],
    pub share: f64,
    pub strength: f64,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    [
        "Size of dqa_actuator_info",
    ][::core::mem::size_of::<dqa_actuator_info>() - 312usize];
    [
        "Alignment of dqa_actuator_info",
    ][::core::mem::align_of::<dqa_actuator_info>() - 8usize];
    [
        "Offset of field: dqa_actuator_info::struct_size",
    ][::core::mem::offset_of!(dqa_actuator_info, struct_size) - 0usize];
    [
        "Offset of field: dqa_actuator_info::category",
    ][::core::mem::offset_of!(dqa_actuator_info, category) - 4usize];
    [
        "Offset of field: dqa_actuator_info::kind",
    ][::core::mem::offset_of!(dqa_actuator_info, kind) - 8usize];
    [
        "Offset of field: dqa_actuator_info::side",
    ][::core::mem::offset_of!(dqa_actuator_info, side) - 12usize];
    [
        "Offset of field: dqa_actuator_info::layers",
    ][::core::mem::offset_of!(dqa_actuator_info, layers) - 16usize];
    [
        "Offset of field: dqa_actuator_info::n_signals",
    ][::core::mem::offset_of!(dqa_actuator_info, n_signals) - 20usize];
    [
        "Offset of field: dqa_actuator_info::first_signal",
    ][::core::mem::offset_of!(dqa_actuator_info, first_signal) - 24usize];
    [
        "Offset of field: dqa_actuator_info::padding",
    ][::core::mem::offset_of!(dqa_actuator_info, padding) - 28usize];
    [
        "Offset of field: dqa_actuator_info::mean",
    ][::core::mem::offset_of!(dqa_actuator_info, mean) - 32usize];
    [
        "Offset of field: dqa_actuator_info::covariance",
    ][::core::mem::offset_of!(dqa_actuator_info, covariance) - 56usize];
    [
        "Offset of field: dqa_actuator_info::half",
    ][::core::mem::offset_of!(dqa_actuator_info, half) - 128usize];
    [
        "Offset of field: dqa_actuator_info::normal",
    ][::core::mem::offset_of!(dqa_actuator_info, normal) - 152usize];
    [
        "Offset of field: dqa_actuator_info::edge",
    ][::core::mem::offset_of!(dqa_actuator_info, edge) - 224usize];
    [
        "Offset of field: dqa_actuator_info::share",
    ][::core::mem::offset_of!(dqa_actuator_info, share) - 296usize];
    [
        "Offset of field: dqa_actuator_info::strength",
    ][::core::mem::offset_of!(dqa_actuator_info, strength) - 304usize];
};
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct dqa_mlp_options {
    pub struct_size: u32,
    pub flags: u32,
    pub n_signals: i32,
    pub dims: i32,
    pub n_hidden: i32,
    pub hidden: [i32; 5usize],
    pub temporal_encoding: i32,
    pub period_steps: i32,
    pub seed: u64,
    pub scale: f64,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of dqa_mlp_options"][::core::mem::size_of::<dqa_mlp_options>() - 64usize];
    [
        "Alignment of dqa_mlp_options",
    ][::core::mem::align_of::<dqa_mlp_options>() - 8usize];
    [
        "Offset of field: dqa_mlp_options::struct_size",
    ][::core::mem::offset_of!(dqa_mlp_options, struct_size) - 0usize];
    [
        "Offset of field: dqa_mlp_options::flags",
    ][::core::mem::offset_of!(dqa_mlp_options, flags) - 4usize];
    [
        "Offset of field: dqa_mlp_options::n_signals",
    ][::core::mem::offset_of!(dqa_mlp_options, n_signals) - 8usize];
    [
        "Offset of field: dqa_mlp_options::dims",
    ][::core::mem::offset_of!(dqa_mlp_options, dims) - 12usize];
    [
        "Offset of field: dqa_mlp_options::n_hidden",
    ][::core::mem::offset_of!(dqa_mlp_options, n_hidden) - 16usize];
    [
        "Offset of field: dqa_mlp_options::hidden",
    ][::core::mem::offset_of!(dqa_mlp_options, hidden) - 20usize];
    [
        "Offset of field: dqa_mlp_options::temporal_encoding",
    ][::core::mem::offset_of!(dqa_mlp_options, temporal_encoding) - 40usize];
    [
        "Offset of field: dqa_mlp_options::period_steps",
    ][::core::mem::offset_of!(dqa_mlp_options, period_steps) - 44usize];
    [
        "Offset of field: dqa_mlp_options::seed",
    ][::core::mem::offset_of!(dqa_mlp_options, seed) - 48usize];
    [
        "Offset of field: dqa_mlp_options::scale",
    ][::core::mem::offset_of!(dqa_mlp_options, scale) - 56usize];
};
pub type dqa_control_evaluate = ::core::option::Option<
    unsafe extern "C" fn(
        step: i64,
        time: f64,
        sensors: *const f64,
        n_sensors: i64,
        theta: *const f64,
        n_parameters: i64,
        actuation: *mut f64,
        n_signals: i64,
        user_data: *mut core::ffi::c_void,
    ) -> i32,
>;
pub type dqa_control_pullback = ::core::option::Option<
    unsafe extern "C" fn(
        step: i64,
        time: f64,
        sensors: *const f64,
        n_sensors: i64,
        theta: *const f64,
        n_parameters: i64,
        actuation_bar: *const f64,
        n_signals: i64,
        theta_bar: *mut f64,
        sensors_bar: *mut f64,
        user_data: *mut core::ffi::c_void,
    ) -> i32,
>;
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct dqa_callback_controller_options {
    pub struct_size: u32,
    pub flags: u32,
    pub n_signals: i32,
    pub n_sensors: i32,
    pub time_step: f64,
    pub evaluate: dqa_control_evaluate,
    pub pullback: dqa_control_pullback,
    pub user_data: *mut core::ffi::c_void,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    [
        "Size of dqa_callback_controller_options",
    ][::core::mem::size_of::<dqa_callback_controller_options>() - 48usize];
    [
        "Alignment of dqa_callback_controller_options",
    ][::core::mem::align_of::<dqa_callback_controller_options>() - 8usize];
    [
        "Offset of field: dqa_callback_controller_options::struct_size",
    ][::core::mem::offset_of!(dqa_callback_controller_options, struct_size) - 0usize];
    [
        "Offset of field: dqa_callback_controller_options::flags",
    ][::core::mem::offset_of!(dqa_callback_controller_options, flags) - 4usize];
    [
        "Offset of field: dqa_callback_controller_options::n_signals",
    ][::core::mem::offset_of!(dqa_callback_controller_options, n_signals) - 8usize];
    [
        "Offset of field: dqa_callback_controller_options::n_sensors",
    ][::core::mem::offset_of!(dqa_callback_controller_options, n_sensors) - 12usize];
    [
        "Offset of field: dqa_callback_controller_options::time_step",
    ][::core::mem::offset_of!(dqa_callback_controller_options, time_step) - 16usize];
    [
        "Offset of field: dqa_callback_controller_options::evaluate",
    ][::core::mem::offset_of!(dqa_callback_controller_options, evaluate) - 24usize];
    [
        "Offset of field: dqa_callback_controller_options::pullback",
    ][::core::mem::offset_of!(dqa_callback_controller_options, pullback) - 32usize];
    [
        "Offset of field: dqa_callback_controller_options::user_data",
    ][::core::mem::offset_of!(dqa_callback_controller_options, user_data) - 40usize];
};
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct dqa_controller_info {
    pub struct_size: u32,
    pub kind: i32,
    pub n_signals: i32,
    pub n_sensors: i32,
    pub has_pullback: i32,
    pub padding: i32,
    pub n_parameters: i64,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    [
        "Size of dqa_controller_info",
    ][::core::mem::size_of::<dqa_controller_info>() - 32usize];
    [
        "Alignment of dqa_controller_info",
    ][::core::mem::align_of::<dqa_controller_info>() - 8usize];
    [
        "Offset of field: dqa_controller_info::struct_size",
    ][::core::mem::offset_of!(dqa_controller_info, struct_size) - 0usize];
    [
        "Offset of field: dqa_controller_info::kind",
    ][::core::mem::offset_of!(dqa_controller_info, kind) - 4usize];
    [
        "Offset of field: dqa_controller_info::n_signals",
    ][::core::mem::offset_of!(dqa_controller_info, n_signals) - 8usize];
    [
        "Offset of field: dqa_controller_info::n_sensors",
    ][::core::mem::offset_of!(dqa_controller_info, n_sensors) - 12usize];
    [
        "Offset of field: dqa_controller_info::has_pullback",
    ][::core::mem::offset_of!(dqa_controller_info, has_pullback) - 16usize];
    [
        "Offset of field: dqa_controller_info::padding",
    ][::core::mem::offset_of!(dqa_controller_info, padding) - 20usize];
    [
        "Offset of field: dqa_controller_info::n_parameters",
    ][::core::mem::offset_of!(dqa_controller_info, n_parameters) - 24usize];
};
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct dqa_tape_options {
    pub struct_size: u32,
    pub flags: u32,
    pub memory_bytes: i64,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of dqa_tape_options"][::core::mem::size_of::<dqa_tape_options>() - 16usize];
    [
        "Alignment of dqa_tape_options",
    ][::core::mem::align_of::<dqa_tape_options>() - 8usize];
    [
        "Offset of field: dqa_tape_options::struct_size",
    ][::core::mem::offset_of!(dqa_tape_options, struct_size) - 0usize];
    [
        "Offset of field: dqa_tape_options::flags",
    ][::core::mem::offset_of!(dqa_tape_options, flags) - 4usize];
    [
        "Offset of field: dqa_tape_options::memory_bytes",
    ][::core::mem::offset_of!(dqa_tape_options, memory_bytes) - 8usize];
};
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct dqa_tape_statistics {
    pub struct_size: u32,
    pub padding: i32,
    pub steps: i64,
    pub bytes: i64,
    pub newton_iterations: i64,
    pub linear_iterations: i64,
    pub adjoint_iterations: i64,
    pub worst_residual: f64,
    pub worst_adjoint_residual: f64,
    pub checkpoints: i64,
    pub recomputed_steps: i64,
    pub rescued_steps: i64,
    pub indefinite_steps: i64,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    [
        "Size of dqa_tape_statistics",
    ][::core::mem::size_of::<dqa_tape_statistics>() - 96usize];
    [
        "Alignment of dqa_tape_statistics",
    ][::core::mem::align_of::<dqa_tape_statistics>() - 8usize];
    [
        "Offset of field: dqa_tape_statistics::struct_size",
    ][::core::mem::offset_of!(dqa_tape_statistics, struct_size) - 0usize];
    [
        "Offset of field: dqa_tape_statistics::padding",
    ][::core::mem::offset_of!(dqa_tape_statistics, padding) - 4usize];
    [
        "Offset of field: dqa_tape_statistics::steps",
    ][::core::mem::offset_of!(dqa_tape_statistics, steps) - 8usize];
    [
        "Offset of field: dqa_tape_statistics::bytes",
    ][::core::mem::offset_of!(dqa_tape_statistics, bytes) - 16usize];
    [
        "Offset of field: dqa_tape_statistics::newton_iterations",
    ][::core::mem::offset_of!(dqa_tape_statistics, newton_iterations) - 24usize];
    [
        "Offset of field: dqa_tape_statistics::linear_iterations",
    ][::core::mem::offset_of!(dqa_tape_statistics, linear_iterations) - 32usize];
    [
        "Offset of field: dqa_tape_statistics::adjoint_iterations",
    ][::core::mem::offset_of!(dqa_tape_statistics, adjoint_iterations) - 40usize];
    [
        "Offset of field: dqa_tape_statistics::worst_residual",
    ][::core::mem::offset_of!(dqa_tape_statistics, worst_residual) - 48usize];
    [
        "Offset of field: dqa_tape_statistics::worst_adjoint_residual",
    ][::core::mem::offset_of!(dqa_tape_statistics, worst_adjoint_residual) - 56usize];
    [
        "Offset of field: dqa_tape_statistics::checkpoints",
    ][::core::mem::offset_of!(dqa_tape_statistics, checkpoints) - 64usize];
    [
        "Offset of field: dqa_tape_statistics::recomputed_steps",
    ][::core::mem::offset_of!(dqa_tape_statistics, recomputed_steps) - 72usize];
    [
        "Offset of field: dqa_tape_statistics::rescued_steps",
    ][::core::mem::offset_of!(dqa_tape_statistics, rescued_steps) - 80usize];
    [
        "Offset of field: dqa_tape_statistics::indefinite_steps",
    ][::core::mem::offset_of!(dqa_tape_statistics, indefinite_steps) - 88usize];
};
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct dqa_objective_term {
    pub struct_size: u32,
    pub kind: i32,
    pub weight: f64,
    pub target: [f64; 3usize],
    pub gamma: f64,
    pub epsilon: f64,
    pub path: *const f64,
    pub n_path: i64,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    [
        "Size of dqa_objective_term",
    ][::core::mem::size_of::<dqa_objective_term>() - 72usize];
    [
        "Alignment of dqa_objective_term",
    ][::core::mem::align_of::<dqa_objective_term>() - 8usize];
    [
        "Offset of field: dqa_objective_term::struct_size",
    ][::core::mem::offset_of!(dqa_objective_term, struct_size) - 0usize];
    [
        "Offset of field: dqa_objective_term::kind",
    ][::core::mem::offset_of!(dqa_objective_term, kind) - 4usize];
    [
        "Offset of field: dqa_objective_term::weight",
    ][::core::mem::offset_of!(dqa_objective_term, weight) - 8usize];
    [
        "Offset of field: dqa_objective_term::target",
    ][::core::mem::offset_of!(dqa_objective_term, target) - 16usize];
    [
        "Offset of field: dqa_objective_term::gamma",
    ][::core::mem::offset_of!(dqa_objective_term, gamma) - 40usize];
    [
        "Offset of field: dqa_objective_term::epsilon",
    ][::core::mem::offset_of!(dqa_objective_term, epsilon) - 48usize];
    [
        "Offset of field: dqa_objective_term::path",
    ][::core::mem::offset_of!(dqa_objective_term, path) - 56usize];
    [
        "Offset of field: dqa_objective_term::n_path",
    ][::core::mem::offset_of!(dqa_objective_term, n_path) - 64usize];
};
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct dqa_gradient_check_options {
    pub struct_size: u32,
    pub flags: u32,
    pub with_respect_to: i32,
    pub n_steps: i32,
    pub seed: u64,
    pub step: f64,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    [
        "Size of dqa_gradient_check_options",
    ][::core::mem::size_of::<dqa_gradient_check_options>() - 32usize];
    [
        "Alignment of dqa_gradient_check_options",
    ][::core::mem::align_of::<dqa_gradient_check_options>() - 8usize];
    [
        "Offset of field: dqa_gradient_check_options::struct_size",
    ][::core::mem::offset_of!(dqa_gradient_check_options, struct_size) - 0usize];
    [
        "Offset of field: dqa_gradient_check_options::flags",
    ][::core::mem::offset_of!(dqa_gradient_check_options, flags) - 4usize];
    [
        "Offset of field: dqa_gradient_check_options::with_respect_to",
    ][::core::mem::offset_of!(dqa_gradient_check_options, with_respect_to) - 8usize];
    [
        "Offset of field: dqa_gradient_check_options::n_steps",
    ][::core::mem::offset_of!(dqa_gradient_check_options, n_steps) - 12usize];
    [
        "Offset of field: dqa_gradient_check_options::seed",
    ][::core::mem::offset_of!(dqa_gradient_check_options, seed) - 16usize];
    [
        "Offset of field: dqa_gradient_check_options::step",
    ][::core::mem::offset_of!(dqa_gradient_check_options, step) - 24usize];
};
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct dqa_gradient_check_report {
    pub struct_size: u32,
    pub one_sided: i32,
    pub adjoint: f64,
    pub finite_difference: f64,
    pub relative_error: f64,
    pub taylor_slope: f64,
    pub gradient_norm: f64,
    pub step: f64,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    [
        "Size of dqa_gradient_check_report",
    ][::core::mem::size_of::<dqa_gradient_check_report>() - 56usize];
    [
        "Alignment of dqa_gradient_check_report",
    ][::core::mem::align_of::<dqa_gradient_check_report>() - 8usize];
    [
        "Offset of field: dqa_gradient_check_report::struct_size",
    ][::core::mem::offset_of!(dqa_gradient_check_report, struct_size) - 0usize];
    [
        "Offset of field: dqa_gradient_check_report::one_sided",
    ][::core::mem::offset_of!(dqa_gradient_check_report, one_sided) - 4usize];
    [
        "Offset of field: dqa_gradient_check_report::adjoint",
    ][::core::mem::offset_of!(dqa_gradient_check_report, adjoint) - 8usize];
    [
        "Offset of field: dqa_gradient_check_report::finite_difference",
    ][::core::mem::offset_of!(dqa_gradient_check_report, finite_difference) - 16usize];
    [
        "Offset of field: dqa_gradient_check_report::relative_error",
    ][::core::mem::offset_of!(dqa_gradient_check_report, relative_error) - 24usize];
    [
        "Offset of field: dqa_gradient_check_report::taylor_slope",
    ][::core::mem::offset_of!(dqa_gradient_check_report, taylor_slope) - 32usize];
    [
        "Offset of field: dqa_gradient_check_report::gradient_norm",
    ][::core::mem::offset_of!(dqa_gradient_check_report, gradient_norm) - 40usize];
    [
        "Offset of field: dqa_gradient_check_report::step",
    ][::core::mem::offset_of!(dqa_gradient_check_report, step) - 48usize];
};
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct dqa_cma_es {
    _unused: [u8; 0],
}
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct dqa_cma_es_options {
    pub struct_size: u32,
    pub flags: u32,
    pub population: i64,
    pub seed: u64,
    pub sigma: f64,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    [
        "Size of dqa_cma_es_options",
    ][::core::mem::size_of::<dqa_cma_es_options>() - 32usize];
    [
        "Alignment of dqa_cma_es_options",
    ][::core::mem::align_of::<dqa_cma_es_options>() - 8usize];
    [
        "Offset of field: dqa_cma_es_options::struct_size",
    ][::core::mem::offset_of!(dqa_cma_es_options, struct_size) - 0usize];
    [
        "Offset of field: dqa_cma_es_options::flags",
    ][::core::mem::offset_of!(dqa_cma_es_options, flags) - 4usize];
    [
        "Offset of field: dqa_cma_es_options::population",
    ][::core::mem::offset_of!(dqa_cma_es_options, population) - 8usize];
    [
        "Offset of field: dqa_cma_es_options::seed",
    ][::core::mem::offset_of!(dqa_cma_es_options, seed) - 16usize];
    [
        "Offset of field: dqa_cma_es_options::sigma",
    ][::core::mem::offset_of!(dqa_cma_es_options, sigma) - 24usize];
};
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct dqa_cma_es_info {
    pub struct_size: u32,
    pub asked: i32,
    pub n: i64,
    pub population: i64,
    pub generation: i64,
    pub evaluations: i64,
    pub sigma: f64,
    pub widest: f64,
    pub axis_ratio: f64,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of dqa_cma_es_info"][::core::mem::size_of::<dqa_cma_es_info>() - 64usize];
    [
        "Alignment of dqa_cma_es_info",
    ][::core::mem::align_of::<dqa_cma_es_info>() - 8usize];
    [
        "Offset of field: dqa_cma_es_info::struct_size",
    ][::core::mem::offset_of!(dqa_cma_es_info, struct_size) - 0usize];
    [
        "Offset of field: dqa_cma_es_info::asked",
    ][::core::mem::offset_of!(dqa_cma_es_info, asked) - 4usize];
    [
        "Offset of field: dqa_cma_es_info::n",
    ][::core::mem::offset_of!(dqa_cma_es_info, n) - 8usize];
    [
        "Offset of field: dqa_cma_es_info::population",
    ][::core::mem::offset_of!(dqa_cma_es_info, population) - 16usize];
    [
        "Offset of field: dqa_cma_es_info::generation",
    ][::core::mem::offset_of!(dqa_cma_es_info, generation) - 24usize];
    [
        "Offset of field: dqa_cma_es_info::evaluations",
    ][::core::mem::offset_of!(dqa_cma_es_info, evaluations) - 32usize];
    [
        "Offset of field: dqa_cma_es_info::sigma",
    ][::core::mem::offset_of!(dqa_cma_es_info, sigma) - 40usize];
    [
        "Offset of field: dqa_cma_es_info::widest",
    ][::core::mem::offset_of!(dqa_cma_es_info, widest) - 48usize];
    [
        "Offset of field: dqa_cma_es_info::axis_ratio",
    ][::core::mem::offset_of!(dqa_cma_es_info, axis_ratio) - 56usize];
};
unsafe extern "C" {
    pub fn dqa_version() -> *const core::ffi::c_char;
    pub fn dqa_abi_version() -> i32;
    pub fn dqa_features() -> *const core::ffi::c_char;
    pub fn dqa_status_name(status: dqa_status) -> *const core::ffi::c_char;
    pub fn dqa_status_text(status: dqa_status) -> *const core::ffi::c_char;
    pub fn dqa_last_error() -> *const core::ffi::c_char;
    pub fn dqa_set_log_handler(
        handler: dqa_log_handler,
        level: i32,
        user_data: *mut core::ffi::c_void,
    ) -> dqa_status;
    pub fn dqa_cancel_token_create(token: *mut *mut dqa_cancel_token) -> dqa_status;
    pub fn dqa_cancel_token_set(token: *mut dqa_cancel_token) -> dqa_status;
    pub fn dqa_cancel_token_reset(token: *mut dqa_cancel_token) -> dqa_status;
    pub fn dqa_cancel_token_free(token: *mut dqa_cancel_token);
    pub fn dqa_shape_space_options_init(
        options: *mut dqa_shape_space_options,
        size: u64,
    ) -> dqa_status;
    pub fn dqa_shape_space_create(
        options: *const dqa_shape_space_options,
        space: *mut *mut dqa_shape_space,
    ) -> dqa_status;
    pub fn dqa_shape_space_free(space: *mut dqa_shape_space);
    pub fn dqa_shape_space_add_mesh(
        space: *mut dqa_shape_space,
        name: *const core::ffi::c_char,
        vertices: *const f64,
        n_vertices: i64,
        triangles: *const i32,
        n_triangles: i64,
        base: *mut i32,
    ) -> dqa_status;
    pub fn dqa_shape_space_add_mesh_file(
        space: *mut dqa_shape_space,
        path: *const core::ffi::c_char,
        base: *mut i32,
    ) -> dqa_status;
    pub fn dqa_shape_space_add_density(
        space: *mut dqa_shape_space,
        name: *const core::ffi::c_char,
        cells: *const f64,
        n: i64,
        base: *mut i32,
    ) -> dqa_status;
    pub fn dqa_shape_space_add_polygon(
        space: *mut dqa_shape_space,
        name: *const core::ffi::c_char,
        corners: *const f64,
        n_corners: i64,
        base: *mut i32,
    ) -> dqa_status;
    pub fn dqa_shape_space_add_image(
        space: *mut dqa_shape_space,
        name: *const core::ffi::c_char,
        pixels: *const f64,
        n_rows: i64,
        n_columns: i64,
        base: *mut i32,
    ) -> dqa_status;
    pub fn dqa_actuator_options_init(
        options: *mut dqa_actuator_options,
        size: u64,
    ) -> dqa_status;
    pub fn dqa_shape_space_add_actuator(
        space: *mut dqa_shape_space,
        base: i32,
        options: *const dqa_actuator_options,
    ) -> dqa_status;
    pub fn dqa_shape_space_get_actuator(
        space: *const dqa_shape_space,
        base: i32,
        category: i32,
        side: i32,
        options: *mut dqa_actuator_options,
    ) -> dqa_status;
    pub fn dqa_shape_space_build(
        space: *mut dqa_shape_space,
        progress: dqa_progress,
        user_data: *mut core::ffi::c_void,
    ) -> dqa_status;
    pub fn dqa_shape_space_get_info(
        space: *const dqa_shape_space,
        info: *mut dqa_shape_space_info,
        size: u64,
    ) -> dqa_status;
    pub fn dqa_shape_space_signal(
        space: *const dqa_shape_space,
        signal: i32,
        info: *mut dqa_signal_info,
        size: u64,
    ) -> dqa_status;
    pub fn dqa_shape_space_base_name(
        space: *const dqa_shape_space,
        base: i32,
    ) -> *const core::ffi::c_char;
    pub fn dqa_shape_space_get_base(
        space: *const dqa_shape_space,
        base: i32,
        cells: *mut f64,
        n: i64,
    ) -> dqa_status;
    pub fn dqa_shape_space_density(
        space: *const dqa_shape_space,
        weights: *const f64,
        m: i64,
        density: *mut f64,
        n: i64,
    ) -> dqa_status;
    pub fn dqa_shape_space_pullback(
        space: *const dqa_shape_space,
        weights: *const f64,
        m: i64,
        density_bar: *const f64,
        n: i64,
        weights_bar: *mut f64,
    ) -> dqa_status;
    pub fn dqa_shape_space_save(
        space: *const dqa_shape_space,
        path: *const core::ffi::c_char,
    ) -> dqa_status;
    pub fn dqa_shape_space_load(
        path: *const core::ffi::c_char,
        space: *mut *mut dqa_shape_space,
    ) -> dqa_status;
    pub fn dqa_simulator_options_init(
        options: *mut dqa_simulator_options,
        size: u64,
    ) -> dqa_status;
    pub fn dqa_simulator_create(
        space: *mut dqa_shape_space,
        options: *const dqa_simulator_options,
        simulator: *mut *mut dqa_simulator,
    ) -> dqa_status;
    pub fn dqa_simulator_free(simulator: *mut dqa_simulator);
    pub fn dqa_simulator_set_weights(
        simulator: *mut dqa_simulator,
        weights: *const f64,
        m: i64,
        progress: dqa_progress,
        user_data: *mut core::ffi::c_void,
    ) -> dqa_status;
    pub fn dqa_simulator_set_material(
        simulator: *mut dqa_simulator,
        young_modulus: *const f64,
        muscle_stiffness: *const f64,
        n: i64,
    ) -> dqa_status;
    pub fn dqa_simulator_set_fixed_nodes(
        simulator: *mut dqa_simulator,
        nodes: *const i32,
        n: i64,
    ) -> dqa_status;
    pub fn dqa_simulator_node_box_index(
        simulator: *const dqa_simulator,
        nodes: *mut i32,
        n: i64,
    ) -> dqa_status;
    pub fn dqa_simulator_set_current_table(
        simulator: *mut dqa_simulator,
        times: *const f64,
        n_times: i64,
        velocities: *const f64,
        n: i64,
    ) -> dqa_status;
    pub fn dqa_simulator_set_current_callback(
        simulator: *mut dqa_simulator,
        current: dqa_current,
        pullback: dqa_current_pullback,
        user_data: *mut core::ffi::c_void,
    ) -> dqa_status;
    pub fn dqa_simulator_get_info(
        simulator: *const dqa_simulator,
        info: *mut dqa_simulator_info,
        size: u64,
    ) -> dqa_status;
    pub fn dqa_simulator_get_weights(
        simulator: *const dqa_simulator,
        weights: *mut f64,
        m: i64,
    ) -> dqa_status;
    pub fn dqa_simulator_suggest_threshold(
        simulator: *const dqa_simulator,
        weights: *const f64,
        m: i64,
        tolerance: f64,
        threshold: *mut f64,
        estimate: *mut f64,
    ) -> dqa_status;
    pub fn dqa_simulator_step(
        simulator: *mut dqa_simulator,
        actuation: *const f64,
        n: i64,
        tape: *mut dqa_tape,
    ) -> dqa_status;
    pub fn dqa_simulator_rollout(
        simulator: *mut dqa_simulator,
        controller: *mut dqa_controller,
        n_steps: i64,
        tape: *mut dqa_tape,
        progress: dqa_progress,
        user_data: *mut core::ffi::c_void,
    ) -> dqa_status;
    pub fn dqa_simulator_get_state(
        simulator: *const dqa_simulator,
        q: *mut f64,
        nq: i64,
        v: *mut f64,
        nv: i64,
    ) -> dqa_status;
    pub fn dqa_simulator_set_state(
        simulator: *mut dqa_simulator,
        q: *const f64,
        nq: i64,
        v: *const f64,
        nv: i64,
    ) -> dqa_status;
    pub fn dqa_simulator_sensors(
        simulator: *const dqa_simulator,
        sensors: *mut f64,
        n: i64,
    ) -> dqa_status;
    pub fn dqa_simulator_forces(
        simulator: *const dqa_simulator,
        forces: *mut f64,
        n: i64,
    ) -> dqa_status;
    pub fn dqa_simulator_surface(
        simulator: *const dqa_simulator,
        vertices: *mut f64,
        nv: i64,
        elements: *mut i32,
        ne: i64,
        n_vertices: *mut i64,
        n_elements: *mut i64,
    ) -> dqa_status;
    pub fn dqa_simulator_mesh(
        simulator: *const dqa_simulator,
        cell_nodes: *mut i32,
        n_cell_nodes: i64,
        cell_box_index: *mut i32,
        n_cells: i64,
        occupancy: *mut f64,
        n_occupancy: i64,
    ) -> dqa_status;
    pub fn dqa_simulator_actuator(
        simulator: *const dqa_simulator,
        category: i32,
        side: i32,
        info: *mut dqa_actuator_info,
        size: u64,
    ) -> dqa_status;
    pub fn dqa_simulator_muscles(
        simulator: *const dqa_simulator,
        cells: *mut i32,
        signals: *mut i32,
        signs: *mut i32,
        n: i64,
        directions: *mut f64,
        nd: i64,
        stiffness: *mut f64,
        ns: i64,
        n_muscles: *mut i64,
    ) -> dqa_status;
    pub fn dqa_controller_create_sinusoid(
        n_signals: i32,
        time_step: f64,
        controller: *mut *mut dqa_controller,
    ) -> dqa_status;
    pub fn dqa_mlp_options_init(options: *mut dqa_mlp_options, size: u64) -> dqa_status;
    pub fn dqa_controller_create_mlp(
        options: *const dqa_mlp_options,
        controller: *mut *mut dqa_controller,
    ) -> dqa_status;
    pub fn dqa_callback_controller_options_init(
        options: *mut dqa_callback_controller_options,
        size: u64,
    ) -> dqa_status;
    pub fn dqa_controller_create_callback(
        options: *const dqa_callback_controller_options,
        theta: *const f64,
        n_parameters: i64,
        controller: *mut *mut dqa_controller,
    ) -> dqa_status;
    pub fn dqa_controller_free(controller: *mut dqa_controller);
    pub fn dqa_controller_get_info(
        controller: *const dqa_controller,
        info: *mut dqa_controller_info,
        size: u64,
    ) -> dqa_status;
    pub fn dqa_controller_n_parameters(
        controller: *const dqa_controller,
        n: *mut i64,
    ) -> dqa_status;
    pub fn dqa_controller_get_parameters(
        controller: *const dqa_controller,
        theta: *mut f64,
        n: i64,
    ) -> dqa_status;
    pub fn dqa_controller_set_parameters(
        controller: *mut dqa_controller,
        theta: *const f64,
        n: i64,
    ) -> dqa_status;
    pub fn dqa_controller_evaluate(
        controller: *const dqa_controller,
        step: i64,
        sensors: *const f64,
        n_sensors: i64,
        actuation: *mut f64,
        n: i64,
    ) -> dqa_status;
    pub fn dqa_controller_save(
        controller: *const dqa_controller,
        path: *const core::ffi::c_char,
    ) -> dqa_status;
    pub fn dqa_controller_load(
        path: *const core::ffi::c_char,
        controller: *mut *mut dqa_controller,
    ) -> dqa_status;
    pub fn dqa_tape_options_init(
        options: *mut dqa_tape_options,
        size: u64,
    ) -> dqa_status;
    pub fn dqa_tape_create(
        simulator: *mut dqa_simulator,
        options: *const dqa_tape_options,
        tape: *mut *mut dqa_tape,
    ) -> dqa_status;
    pub fn dqa_tape_free(tape: *mut dqa_tape);
    pub fn dqa_tape_clear(tape: *mut dqa_tape) -> dqa_status;
    pub fn dqa_tape_n_steps(tape: *const dqa_tape, n_steps: *mut i64) -> dqa_status;
    pub fn dqa_tape_get_state(
        tape: *mut dqa_tape,
        step: i64,
        q: *mut f64,
        nq: i64,
        v: *mut f64,
        nv: i64,
    ) -> dqa_status;
    pub fn dqa_tape_get_actuation(
        tape: *mut dqa_tape,
        step: i64,
        actuation: *mut f64,
        n: i64,
    ) -> dqa_status;
    pub fn dqa_tape_get_current(
        tape: *mut dqa_tape,
        step: i64,
        current: *mut f64,
        n: i64,
    ) -> dqa_status;
    pub fn dqa_tape_get_surface(
        tape: *mut dqa_tape,
        step: i64,
        vertices: *mut f64,
        nv: i64,
    ) -> dqa_status;
    pub fn dqa_tape_stats(
        tape: *const dqa_tape,
        statistics: *mut dqa_tape_statistics,
        size: u64,
    ) -> dqa_status;
    pub fn dqa_objective_term_init(
        term: *mut dqa_objective_term,
        size: u64,
    ) -> dqa_status;
    pub fn dqa_tape_objective(
        tape: *mut dqa_tape,
        terms: *const dqa_objective_term,
        n_terms: i64,
        loss: *mut f64,
        per_term: *mut f64,
    ) -> dqa_status;
    pub fn dqa_adjoint_create(
        tape: *mut dqa_tape,
        adjoint: *mut *mut dqa_adjoint,
    ) -> dqa_status;
    pub fn dqa_adjoint_free(adjoint: *mut dqa_adjoint);
    pub fn dqa_adjoint_seed(
        adjoint: *mut dqa_adjoint,
        step: i64,
        quantity: i32,
        bar: *const f64,
        n: i64,
    ) -> dqa_status;
    pub fn dqa_adjoint_seed_objective(
        adjoint: *mut dqa_adjoint,
        terms: *const dqa_objective_term,
        n_terms: i64,
    ) -> dqa_status;
    pub fn dqa_adjoint_backward(
        adjoint: *mut dqa_adjoint,
        to_step: i64,
        progress: dqa_progress,
        user_data: *mut core::ffi::c_void,
    ) -> dqa_status;
    pub fn dqa_adjoint_get(
        adjoint: *mut dqa_adjoint,
        with_respect_to: i32,
        out: *mut f64,
        n: i64,
    ) -> dqa_status;
    pub fn dqa_gradient_check_options_init(
        options: *mut dqa_gradient_check_options,
        size: u64,
    ) -> dqa_status;
    pub fn dqa_check_gradient(
        simulator: *const dqa_simulator,
        controller: *const dqa_controller,
        terms: *const dqa_objective_term,
        n_terms: i64,
        options: *const dqa_gradient_check_options,
        report: *mut dqa_gradient_check_report,
        report_size: u64,
    ) -> dqa_status;
    pub fn dqa_adam_step(
        x: *mut f64,
        gradient: *const f64,
        rates: *const f64,
        first_moment: *mut f64,
        second_moment: *mut f64,
        n: i64,
        iteration: i64,
    ) -> dqa_status;
    pub fn dqa_project_simplex(x: *mut f64, n: i64) -> dqa_status;
    pub fn dqa_cma_es_options_init(
        options: *mut dqa_cma_es_options,
        size: u64,
    ) -> dqa_status;
    pub fn dqa_cma_es_create(
        options: *const dqa_cma_es_options,
        mean: *const f64,
        scales: *const f64,
        n: i64,
        search: *mut *mut dqa_cma_es,
    ) -> dqa_status;
    pub fn dqa_cma_es_free(search: *mut dqa_cma_es);
    pub fn dqa_cma_es_ask(
        search: *mut dqa_cma_es,
        candidates: *mut f64,
        count: i64,
    ) -> dqa_status;
    pub fn dqa_cma_es_tell(
        search: *mut dqa_cma_es,
        values: *const f64,
        population: i64,
    ) -> dqa_status;
    pub fn dqa_cma_es_best(
        search: *const dqa_cma_es,
        x: *mut f64,
        n: i64,
        value: *mut f64,
    ) -> dqa_status;
    pub fn dqa_cma_es_mean(
        search: *const dqa_cma_es,
        mean: *mut f64,
        n: i64,
    ) -> dqa_status;
    pub fn dqa_cma_es_get_info(
        search: *const dqa_cma_es,
        info: *mut dqa_cma_es_info,
        size: u64,
    ) -> dqa_status;
    pub fn dqa_cma_es_save(
        search: *const dqa_cma_es,
        path: *const core::ffi::c_char,
    ) -> dqa_status;
    pub fn dqa_cma_es_load(
        path: *const core::ffi::c_char,
        search: *mut *mut dqa_cma_es,
    ) -> dqa_status;
}
