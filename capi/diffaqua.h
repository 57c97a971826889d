/* SPDX-License-Identifier: MIT
 *
 * diffaqua.h — co-design of soft underwater swimmers: shape space, simulator, controller, tape, adjoint.
 *
 * Conventions, valid for every function below unless its comment says otherwise:
 *  - Status. Functions return dqa_status: 0 (DQA_SUCCESS) or a negative code; nothing exits, aborts or prints.
 *    dqa_last_error() then tells, for the calling thread, which argument was wrong, what was expected and what came.
 *  - Arrays. `double *` (or `int32_t *` for connectivity) with an int64_t count of ELEMENTS of the array, which is
 *    checked; C-contiguous, row-major; the shape stands in the comment. The caller owns every buffer. An output
 *    pointer may be NULL where the comment says "NULL: not wanted".
 *  - Handles. A child keeps its parents alive: handles may be freed in any order; free(NULL) is legal. Creators write
 *    NULL to their output on failure.
 *  - Options. Growable structs begin with struct_size; fill them with the matching _init function and change fields
 *    afterwards. Older (smaller) and newer (larger, zero-tailed) structs are accepted. NULL options mean defaults.
 *  - Threads. Distinct objects may be used concurrently. One object is used by one thread at a time, except that a
 *    built shape space and a finished tape are read-only and may be shared. A
 *    calling thread needs a stack of 256 KiB, 90 of which hold the thread-local variables of OpenBLAS and METIS. A
 *    child of fork may use the library with any number of threads, with handles of its own or its parent's, unless
 *    another thread of the parent was in a call with them.
 *  - Units. SI: metres, seconds, kilograms, newtons, pascals. The swimmer heads along +x; y is lateral; z is up.
 *  - All functions exist since version 0.1 unless marked otherwise.
 */
#ifndef DIFFAQUA_H
#define DIFFAQUA_H

#include <stdint.h>

#if defined(__GNUC__) && !defined(DQA_NO_VISIBILITY)
#define DQA_API __attribute__((visibility("default"))) /* marks what the shared library exports */
#else
#define DQA_API /* marks what the shared library exports */
#endif

#ifdef __cplusplus
extern "C" {
#endif

#define DQA_VERSION_MAJOR 0  /* of the header; a program may compare it with dqa_version() */
#define DQA_VERSION_MINOR 1  /* below 1.0 a new one may change the ABI */
#define DQA_VERSION_PATCH 0  /* never changes the ABI */
#define DQA_ABI_VERSION 0    /* see dqa_abi_version */

/* ------------------------------------------------------------------ status */
/* What every call returns: 0 or one of the negative codes below. */
typedef int32_t dqa_status;
#define DQA_SUCCESS 0              /* all went well */
#define DQA_ERROR_ARGUMENT (-1)    /* an argument is out of its range; the message names it */
#define DQA_ERROR_STATE (-2)       /* the call does not fit the state of the object (double build, passed step) */
#define DQA_ERROR_FILE (-3)        /* a file's content is not what was expected */
#define DQA_ERROR_IO (-4)          /* a file could not be opened, read or written */
#define DQA_ERROR_MESH (-5)        /* a mesh is open, inconsistently oriented, empty or not finite */
#define DQA_ERROR_MEMORY (-6)      /* out of memory */
#define DQA_ERROR_UNSUPPORTED (-7) /* this build or version cannot do it */
#define DQA_NOT_CONVERGED (-8)     /* an iteration stopped above its tolerance; the message names step, residual, cell */
#define DQA_DIVERGED (-9)          /* a state became non-finite; the message names the step */
#define DQA_CANCELLED (-10)        /* a callback or cancel token asked to stop; the object is still usable */
#define DQA_ERROR_INTERNAL (-11)   /* a defect of the library: please report it */

/* Version of the loaded library as "major.minor.patch". Never NULL, static. */
DQA_API const char *dqa_version(void);
/* ABI generation (the SOVERSION); programs may refuse a library whose number differs from DQA_ABI_VERSION. */
DQA_API int32_t dqa_abi_version(void);
/* Space-separated list of what this build can do, e.g. "stl obj ply cholmod umfpack openmp avx2 avx512": mesh
 * files that it reads, solvers, instruction sets. Static. */
DQA_API const char *dqa_features(void);
/* "DQA_ERROR_MESH" for a code, "unknown status" otherwise. Static. */
DQA_API const char *dqa_status_name(dqa_status status);
/* One sentence on what a code means. Static. */
DQA_API const char *dqa_status_text(dqa_status status);
/* Message of the last failed call on this thread; "" when none failed. Valid until the thread's next failing call. */
DQA_API const char *dqa_last_error(void);

#define DQA_LOG_ERROR 1   /* a call is about to fail for a reason that its message does not hold */
#define DQA_LOG_WARNING 2 /* the result is right, but not the way or the input that one would expect */
#define DQA_LOG_INFO 3    /* about one message a call */
#define DQA_LOG_DEBUG 4   /* about one message a step or solve */
/* Receives messages of level <= the level given to dqa_set_log_handler; may be called from any thread. */
typedef void (*dqa_log_handler)(int32_t level, const char *message, void *user_data);
/* Process-wide; NULL handler silences the library, which is the default. Safe from any thread; a message under way in
 * another thread may still reach the handler that is replaced, so keep its user_data for as long as such calls run.
 * The handler may call the library. Texts are for people and may change. Messages: WARNING for input or a way of
 * solving that one would not expect (mended meshes, a step whose method failed and another one did not, an adjoint that
 * fell back on a factorisation); INFO for each
 * design; DEBUG for each barycentre and step. */
DQA_API dqa_status dqa_set_log_handler(dqa_log_handler handler, int32_t level, void *user_data);

/* Progress of a long call: `done` of `total` units; called on the calling thread; non-zero cancels (DQA_CANCELLED). This
 * and every other callback, log handlers among them, may call any function with any handle: reads of the objects of the
 * call that it comes from are answered, a change of one (the simulator that is being stepped, the tape that is being
 * recorded, the adjoint that sweeps, the controller that drives, the space that is being built) is refused with
 * DQA_ERROR_STATE, and one that is freed lives until the call ends. */
typedef int32_t (*dqa_progress)(int64_t done, int64_t total, void *user_data);

/* ------------------------------------------------------------------ cancel token */
/* Stops long calls from another thread or a signal handler. */
typedef struct dqa_cancel_token dqa_cancel_token;
/* A new token that is not set. Objects whose options name it keep what they need of it: it may be freed before them. */
DQA_API dqa_status dqa_cancel_token_create(dqa_cancel_token **token);
/* Asks every call that watches the token to stop. Async-signal-safe; may be called from any thread. */
DQA_API dqa_status dqa_cancel_token_set(dqa_cancel_token *token);
/* Lets the calls that watch the token run again. May be called from any thread. */
DQA_API dqa_status dqa_cancel_token_reset(dqa_cancel_token *token);
/* NULL: nothing happens. Not while another thread or a signal handler may still set it. */
DQA_API void dqa_cancel_token_free(dqa_cancel_token *token);

/* ------------------------------------------------------------------ shape space */
/* A box of cells with base shapes, their actuators, and the Wasserstein interpolation between them
 * (convolutional barycentre: Solomon et al. 2015). Filled, then frozen by dqa_shape_space_build. */
typedef struct dqa_shape_space dqa_shape_space;

#define DQA_PEAK_SMOOTH 0 /* M = sum p^65 / sum p^64: differentiable */
#define DQA_PEAK_PAPER 1  /* M = max p: as the paper; its derivative is that of one cell and fails finite differences */

#define DQA_UP_AUTO 0 /* the lateral axis is the one across which the mesh mirrors best; ties keep +z up */
#define DQA_UP_Z 1    /* the mesh is used as it is: x heading, z up */
#define DQA_UP_Y 2    /* the mesh has y up: it is turned by 90 degrees about x */

#define DQA_INTERPOLATION_LINEAR 0 /* mean, eigenvalues and Euler angles are linear in the weights: as the paper */
#define DQA_INTERPOLATION_BURES 1  /* mean linear, covariance the Bures-Wasserstein barycentre (Agueh & Carlier 2011):
                                      the optimal transport of Gaussians; the box's frame as with LINEAR */

/* Box, meshes, interpolation. */
typedef struct dqa_shape_space_options {
    uint32_t struct_size;
    uint32_t flags;          /* must be 0 */
    int32_t dims;            /* 3 (default), or 2: the plane x heading, y lateral, in plane strain; masses and forces are
                                those of a slab one cell thick, and cells_z counts as 1 whatever it is */
    int32_t cells_x;         /* number of cells along x, y, z; each in [8, 512]; default 60, 16, 26 */
    int32_t cells_y;  /* see cells_x */
    int32_t cells_z;  /* see cells_x */
    int32_t margin;          /* empty cells kept ahead of and behind every mesh, >= 1; default 2 */
    int32_t margin_across;   /* empty cells kept beside, above and below it, >= 0; default 0 */
    int32_t up;              /* DQA_UP_*: which way the meshes added later stand */
    int32_t subsamples;      /* in [1, 16]; default 8. Without effect: covered fractions are exact, however thin a part
                                is; kept so that programs that set it go on working */
    int32_t peak;            /* DQA_PEAK_* */
    int32_t max_iterations;  /* of the barycentre; default 5000 */
    int32_t threads;         /* >= 1; results do not depend on it; default 1 */
    int32_t padding;         /* must be 0 */
    double body_length;      /* m, in [1e-9, 1e9]: length of the longest base; sets the cell size; default 1 */
    double cell_size;        /* m: 0 (default), or in [1e-9, 1e9], in place of body_length */
    double sigma;            /* width of the Gaussian kernel, in cells, in [0.2, 16]; default 0.4 */
    double tolerance;        /* marginal error (1-norm) at which the barycentre stops; default 1e-9 */
    dqa_cancel_token *cancel; /* NULL: none */
    int32_t interpolation;   /* DQA_INTERPOLATION_*: of actuators between the bases */
    int32_t automatic_fins;  /* 1: bases without any actuator also get fins where their geometry has them; default 0 */
    int64_t refinement;      /* in [1, 4]: each cell is cut into as many along every axis, mass moves between those, and the
                                density of a cell is their sum; sigma still counts whole cells. A kernel narrower than
                                about 0.7 of the edge of the cells between which mass moves makes a comb of a body that
                                is stretched, and thin parts of shapes between the bases come loose: 2 leaves hardly any
                                of that at the default width. Time and memory grow with its power of dims; default 1 */
} dqa_shape_space_options;

/* Fills *options with defaults; `size` is sizeof(dqa_shape_space_options) as the caller compiled it. */
DQA_API dqa_status dqa_shape_space_options_init(dqa_shape_space_options *options, uint64_t size);
/* An open space without bases. */
DQA_API dqa_status dqa_shape_space_create(const dqa_shape_space_options *options, dqa_shape_space **space);
/* NULL: nothing happens. Simulators of the space keep what they need of it. */
DQA_API void dqa_shape_space_free(dqa_shape_space *space);

/* Adds a base from a closed triangle mesh. vertices [n_vertices][3], any unit; triangles [n_triangles][3].
 * The mesh is scaled uniformly to fit the box with its margins and centred by its centre of mass.
 * n_vertices and n_triangles count rows. *base receives the index of the base (NULL: not wanted). */
DQA_API dqa_status dqa_shape_space_add_mesh(dqa_shape_space *space, const char *name, const double *vertices,
                                            int64_t n_vertices, const int32_t *triangles, int64_t n_triangles,
                                            int32_t *base);
/* The same from an STL (binary or ASCII), OBJ or PLY file (ASCII or binary); the base is named after the file, whose
 * extension tells the format. Polygons and triangle strips are cut into triangles; normals, texture coordinates, colours
 * and whatever else a file holds are passed over. Coordinates are kept in double precision. Time and memory grow with
 * the file's size, 1 GiB at most. In both calls vertices within 1e-6 of the mesh's extent are merged where only that
 * closes it (with a log message). DQA_ERROR_IO for what cannot be read or is no regular file, DQA_ERROR_FILE for content
 * that is not understood (the message names the line or element, and what was expected), DQA_ERROR_MESH for a surface
 * that is not closed, DQA_CANCELLED. */
DQA_API dqa_status dqa_shape_space_add_mesh_file(dqa_shape_space *space, const char *path, int32_t *base);
/* Adds a base from covered fractions in [0, 1], shape [cells_x][cells_y][cells_z]; n = product of the three. */
DQA_API dqa_status dqa_shape_space_add_density(dqa_shape_space *space, const char *name, const double *cells, int64_t n,
                                               int32_t *base);
/* Adds a base to a space of two dimensions from a closed simple polygon: corners [n_corners][2] = (x, y), any unit and
 * either sense of rotation, the last corner joined to the first. Scaled uniformly to fit the box with its margins and
 * centred by its centre of mass, as meshes are; the covered area of every cell is exact. n_corners counts rows, in
 * [3, 16384]. DQA_ERROR_ARGUMENT for a polygon that crosses or touches itself. */
DQA_API dqa_status dqa_shape_space_add_polygon(dqa_shape_space *space, const char *name, const double *corners,
                                               int64_t n_corners, int32_t *base);
/* The same from grey values in [0, 1] (1: body), pixels [n_rows][n_columns] of square pixels at any resolution, in the
 * order of image files: the first row is the top (largest y, the swimmer's left), the first column the left of the
 * picture (least x, the tail's side; the swimmer looks to the right). Every cell gets the mean over its area. */
DQA_API dqa_status dqa_shape_space_add_image(dqa_shape_space *space, const char *name, const double *pixels,
                                             int64_t n_rows, int64_t n_columns, int32_t *base);

#define DQA_ACTUATOR_CAUDAL 0 /* antagonistic pair split at the plane y = 0, fibres along x: one signal */
#define DQA_ACTUATOR_FINS 1   /* a left and a right fin that share 4 signals per layer: 16 with four layers */

#define DQA_SIDE_BOTH 0  /* caudal; or fins of which the left one is described and the right one mirrors it at y = 0 */
#define DQA_SIDE_LEFT 1  /* the fin at y > 0 alone */
#define DQA_SIDE_RIGHT 2 /* the fin at y < 0 alone */

/* A muscle region as a Gaussian: the box around the half-peak ellipsoid, with semi-axes sqrt(2 ln 2 * variance).
 *
 * The category is a number of the caller's choice: actuators of the same category are interpolated between the bases,
 * and it must have the same kind (and layers) in all of them. Any number of categories from 0 to 15 may be used; the
 * automatic ones are 0 (caudal) and 1 (fins). The signals of a space are those of its categories in rising order: one
 * for a caudal category, 4 * layers for fins; dqa_shape_space_signal tells which is which.
 *
 * The axes of a fin have fixed roles: the first points ahead, the second towards +y, the third through its thickness
 * (variance[2] is the smallest). Layers are equal parts of the thickness, from below; every layer has four groups, equal
 * bands side by side across the fin from back inside to ahead outside, with fibres at 45 degrees: back and outwards. Both
 * halves contract for a positive signal. Boundaries of boxes, layers and bands are ramps one cell wide.
 *
 * In a space of two dimensions mean[2] and variance[2] have no meaning, euler[0] and euler[1] must be 0, and fins have
 * one layer. */
typedef struct dqa_actuator_options {
    uint32_t struct_size;
    uint32_t flags;      /* must be 0 */
    int32_t category;    /* in [0, 15]; default 0 */
    int32_t kind;        /* DQA_ACTUATOR_*; default caudal */
    double mean[3];      /* m, in the box's frame (origin at the box's centre) */
    double variance[3];  /* m^2, > 0: eigenvalues of the covariance along the actuator's own axes */
    double euler[3];     /* rad: Sigma = R^T diag(variance) R with R = Rx(e0) Ry(e1) Rz(e2): its rows are the axes */
    int32_t side;        /* DQA_SIDE_*; caudal: DQA_SIDE_BOTH, the default */
    int32_t layers;      /* of fins, in [1, 4]; default 4; not used by caudal ones */
} dqa_actuator_options;
/* Fills *options with defaults; `size` is sizeof(dqa_actuator_options) as the caller compiled it. */
DQA_API dqa_status dqa_actuator_options_init(dqa_actuator_options *options, uint64_t size);
/* Gives base `base` an actuator; at most one of each category and side. Lengths need the cell size: set
 * options.cell_size > 0 at creation to use this function. Bases without any actuator get a caudal one placed from
 * their geometry at build: from the peduncle (the narrowest section in the rear, with a wider tail fin behind it) to the
 * middle of the body; without a peduncle, as in eels, from 40 to 90 % of the length measured from the tail. With
 * options.automatic_fins they also get a pair of fins where the body has some: what reaches at least two cells beyond
 * the trunk on both sides. */
DQA_API dqa_status dqa_shape_space_add_actuator(dqa_shape_space *space, int32_t base,
                                                const dqa_actuator_options *options);
/* Reads the actuator of a base (after build: also an automatic one); options->struct_size is that of the _init
 * function. side: DQA_SIDE_BOTH for caudal ones, DQA_SIDE_LEFT or DQA_SIDE_RIGHT for fins. DQA_ERROR_STATE if it has
 * none. */
DQA_API dqa_status dqa_shape_space_get_actuator(const dqa_shape_space *space, int32_t base, int32_t category,
                                                int32_t side, dqa_actuator_options *options);
/* Freezes the space: base densities, cell size, automatic actuators, sensor axis. DQA_ERROR_ARGUMENT, with the space as
 * it was, for a base of which no cell is covered by half or more: it is too thin for the grid. */
DQA_API dqa_status dqa_shape_space_build(dqa_shape_space *space, dqa_progress progress, void *user_data);

/* What dqa_shape_space_get_info tells. */
typedef struct dqa_shape_space_info {
    uint32_t struct_size;
    int32_t dims;  /* 2 or 3 */
    int32_t cells_x;  /* cells along x */
    int32_t cells_y;  /* cells along y */
    int32_t cells_z;  /* cells along z; 1 in two dimensions */
    int32_t n_bases;  /* base shapes added so far */
    int32_t n_signals;  /* actuation signals that a simulator of this space takes per step; 0 before build */
    int32_t is_built;   /* 0 or 1 */
    int64_t n_cells;    /* cells_x * cells_y * cells_z */
    double cell_size;   /* m; 0 before build when it is automatic */
} dqa_shape_space_info;
/* `size` is sizeof(dqa_shape_space_info) as the caller compiled it. */
DQA_API dqa_status dqa_shape_space_get_info(const dqa_shape_space *space, dqa_shape_space_info *info, uint64_t size);

/* What one actuation signal drives. */
typedef struct dqa_signal_info {
    uint32_t struct_size;
    int32_t category; /* number of the actuators that it drives, in [0, 15] */
    int32_t kind;     /* DQA_ACTUATOR_* */
    int32_t layer;    /* of fins, from 0 below; 0 for caudal */
    int32_t group;    /* of fins, the band in [0, 4) from back inside to ahead outside; 0 for caudal */
    int32_t padding;  /* 0 */
} dqa_signal_info;
/* What signal `signal` in [0, n_signals) of a built space drives. `size` is sizeof(dqa_signal_info). */
DQA_API dqa_status dqa_shape_space_signal(const dqa_shape_space *space, int32_t signal, dqa_signal_info *info,
                                          uint64_t size);
/* Name of a base, or "" when there is no such base. Valid as long as the space. */
DQA_API const char *dqa_shape_space_base_name(const dqa_shape_space *space, int32_t base);
/* Covered fractions of a base, shape [cells_x][cells_y][cells_z]. */
DQA_API dqa_status dqa_shape_space_get_base(const dqa_shape_space *space, int32_t base, double *cells, int64_t n);
/* Density of the barycentre divided by its peak, shape [cells_x][cells_y][cells_z]; the body is where it exceeds 1/2.
 * weights [n_bases] on the simplex (>= 0, sum 1 within 1e-9). */
DQA_API dqa_status dqa_shape_space_density(const dqa_shape_space *space, const double *weights, int64_t m,
                                           double *density, int64_t n);
/* Pullback of dqa_shape_space_density by implicit differentiation: weights_bar [n_bases] is the mean-free gradient. */
DQA_API dqa_status dqa_shape_space_pullback(const dqa_shape_space *space, const double *weights, int64_t m,
                                            const double *density_bar, int64_t n, double *weights_bar);
/* Writes a built space (atomically: a temporary file, then rename) and reads it back with the same bits. */
DQA_API dqa_status dqa_shape_space_save(const dqa_shape_space *space, const char *path);
/* The built space of a file; DQA_ERROR_FILE if it is none, is damaged or of a later version. */
DQA_API dqa_status dqa_shape_space_load(const char *path, dqa_shape_space **space);

/* ------------------------------------------------------------------ simulator */
/* One scene: a shape space, material, water, time step, solver; the current design (weights) and state (q, v). */
typedef struct dqa_simulator dqa_simulator;
/* Parameters theta and the map from them to actuation. */
typedef struct dqa_controller dqa_controller;
/* The record of one rollout. */
typedef struct dqa_tape dqa_tape;
/* A cursor that walks back over a tape, with the cotangents it has gathered. */
typedef struct dqa_adjoint dqa_adjoint;

#define DQA_METHOD_NEWTON_PCG 0    /* Newton, conjugate gradients with the scene's DQA_PRECONDITIONER_* */
#define DQA_METHOD_NEWTON_DIRECT 1 /* Newton with a sparse factorisation of the exact Hessian: the oracle */

#define DQA_METHOD_PROJECTIVE 2    /* L-BFGS on the projective-dynamics factor (Liu et al. 2017), as the paper: no Hessian
                                      forward; its adjoint is that of NEWTON_PCG */

#define DQA_PRECONDITIONER_MULTILEVEL 0 /* diagonal blocks and a multigrid cycle, turned with the body */
#define DQA_PRECONDITIONER_FACTOR 1 /* the projective-dynamics factor in place of the diagonal blocks, as METHOD_PROJECTIVE
                                       has it in any case: dearer on most scenes */

#define DQA_PRECISION_SINGLE 0 /* 24 bits: half the memory traffic, twice as many numbers at once */
#define DQA_PRECISION_DOUBLE 1 /* 53 bits */

#define DQA_INTEGRATOR_IMPLICIT_EULER 0 /* first order, strongly damped: as the paper */
#define DQA_INTEGRATOR_BDF2 1 /* second order at the same cost; the first step, and the first after
                                 dqa_simulator_set_state, is one of implicit Euler */

/* Elastic energy densities of the deformation gradient F with rotation R, mu = E / (2 (1 + nu)),
 * lambda = E nu / ((1 + nu) (1 - 2 nu)). Volume terms are integrated with one point a cell, the rest as
 * DQA_QUADRATURE_* says (selective reduced integration), so that cells do not lock as nu approaches 1/2. */
#define DQA_MATERIAL_COROTATED 0 /* mu |F - R|^2, as the paper: lambda does not enter, the uniaxial modulus is 2 mu */
#define DQA_MATERIAL_COROTATED_VOLUME 1 /* mu |F - R|^2 + lambda/2 (tr(R^T F) - 3)^2 */
#define DQA_MATERIAL_NEO_HOOKEAN 2 /* stable neo-Hookean (Smith, de Goes & Kim 2018) with the same small-strain moduli */

#define DQA_QUADRATURE_FULL 0    /* 2^dims Gauss points a cell, as the paper: a fin one cell thick bends half again too
                                    stiffly (shear locking) */
#define DQA_QUADRATURE_REDUCED 1 /* one point a cell, and a stiffness against the modes that it does not see (hourglass
                                    control after Flanagan & Belytschko 1981): about a quarter faster, and one layer of
                                    cells bends as beam theory wants. Muscles keep 2^dims points */

#define DQA_WATER_NONE 0     /* no water: the body moves in empty space */
#define DQA_WATER_IMPLICIT 1 /* lagged coefficients in a convex dissipation of the new velocity */
#define DQA_WATER_EXPLICIT 2 /* for comparison: drag and thrust at the start of the step, constant during it, as the
                                paper's public code has them; light surface nodes blow up at ordinary time steps */

#define DQA_FACES_BOTH 0     /* every face of the surface counts, as the paper's equations say */
#define DQA_FACES_WINDWARD 1 /* for comparison: only faces that move into the water (n . v_rel < 0 at the start of the
                                step) count, as in the paper's public code. The force jumps at Phi = 0: gradients hold
                                within one set of counted faces and are not promised to pass finite differences */

/* Material, water, time integration and solver of a scene. */
typedef struct dqa_simulator_options {
    uint32_t struct_size;
    uint32_t flags;              /* must be 0 */
    int32_t threads;             /* >= 1, at most so many (a small body takes fewer); the bits of every result are the same
                                    for any number; default 1 */
    int32_t method;              /* DQA_METHOD_* */
    int32_t water;               /* DQA_WATER_* */
    int32_t max_newton;          /* Newton iterations per step; default 50. Where the method fails, another one may take
                                    10 (max_newton - 1) more from there, and as many from the step's start */
    int32_t max_linear;          /* conjugate-gradient iterations per linear solve, or L-BFGS iterations per step; default
                                    2000 */
    int32_t instruction_set;     /* 0 automatic (default), 1 baseline, 2 AVX2, 3 AVX-512: speed only */
    int32_t integrator;          /* DQA_INTEGRATOR_*: default implicit Euler */
    int32_t material;            /* DQA_MATERIAL_*: default corotated, the paper's */
    int32_t planar;              /* 1: no node moves along z (a constraint); default 0; of no effect in two dimensions */
    int32_t preconditioner;      /* DQA_PRECONDITIONER_*: speed only; default DQA_PRECONDITIONER_MULTILEVEL */
    double time_step;            /* s, in [1e-12, 1e12]; default 1/30 */
    double young_modulus;        /* Pa, in [1e-12, 1e18]: of the solid; cells scale it by their occupancy; default 5e6 */
    double poisson_ratio;        /* in [0, 0.5); default 0.45 (of material COROTATED only mu enters) */
    double density;              /* kg/m^3, in [1e-12, 1e18]; default 1000 */
    double muscle_stiffness;     /* Pa, in [0, 1e18]; default 2e6 */
    double contraction;          /* c in (0, 1): a signal u commands the rest ratios 1 - c u and 1 + c u; default 0.2 */
    double threshold;            /* tau in [0, 0.5): cells whose density exceeds it are simulated; default 0.02 */
    double occupancy_floor;      /* least occupancy of a simulated cell, in [1e-12, 0.1]; default 1e-10 */
    double tolerance;            /* force residual relative to the forces (to the rounding of positions where forces
                                    vanish) at which a step stops, in (0, 1); default 1e-6. It also stops only where the
                                    error of the new positions, as Newton's correction estimates it, is at most 5
                                    `tolerance` of the way moved in the step, in the norm of the mass, and 50 `tolerance`
                                    over all nodes alike, nearly empty cells among them (ways count as 1e-4 cells at
                                    least); otherwise it is corrected further */
    double adjoint_tolerance;    /* relative residual of the adjoint's linear solves, in [0, 1); default 0: 0.3 `tolerance`
                                    on a tape of up to 100 steps, and on a longer one so much less that what is left does
                                    not add up; less also where forces in a stiff body are far larger than what moves
                                    it. Smaller ones do not make gradients more accurate. With a loose `tolerance`, or a
                                    rollout in many short tapes, give one */
    double water_density;        /* kg/m^3, in [1e-12, 1e18]; default 1000 */
    double current[3];           /* m/s: velocity of the water; in two dimensions [2] must be 0; default 0 */
    double drag_coefficients[4];   /* cubic Bezier ordinates of Cd over |Phi|/(pi/2). The curve, not each ordinate, must
                                      be >= 0 at every angle, as rounded by angle_smoothing */
    double thrust_coefficients[4]; /* cubic Bezier ordinates of Ct over Phi/pi + 1/2. The curve must nowhere fall */
    double speed_smoothing;      /* m/s, in [1e-12, 1e18]: |v| becomes sqrt(v^2 + eps^2); default 1e-2 */
    double angle_smoothing;      /* rad, in (0, 0.5]: rounds the cone of Cd and Ct at head-on flow; default 0.02 */
    double surface_smoothing;    /* in [1e-12, 1e18]: face weight sqrt(dG^2 + eps^2) - eps of an occupancy jump dG; default 1e-2 */
    dqa_cancel_token *cancel;    /* NULL: none */
    int32_t water_faces;         /* DQA_FACES_*: default DQA_FACES_BOTH */
    int32_t linear_precision;    /* DQA_PRECISION_*: default DQA_PRECISION_SINGLE. Of the iterations of linear solves
                                    with DQA_PRECONDITIONER_MULTILEVEL, whose residuals are checked in double
                                    precision, so that results are as exact with both; of the preconditioner alone
                                    with DQA_PRECONDITIONER_FACTOR. All else is in double precision. Where inertia is so
                                    small beside stiffness that single precision loses it (small or stiff bodies, long
                                    steps) double precision is taken */
    int32_t quadrature;          /* DQA_QUADRATURE_*: default DQA_QUADRATURE_REDUCED */
    int32_t padding;             /* must be 0 */
    int64_t max_products;        /* products with the Hessian that a step may take, >= 1: a bound of its work. A step that
                                    has taken so many, and by then ends no linear solve, fails with DQA_NOT_CONVERGED.
                                    Default 200000; ordinary steps take tens to hundreds. */
} dqa_simulator_options;

/* Fills *options with defaults; `size` is sizeof(dqa_simulator_options) as the caller compiled it. */
DQA_API dqa_status dqa_simulator_options_init(dqa_simulator_options *options, uint64_t size);
/* The space must be built. The new simulator has no design yet: call dqa_simulator_set_weights. */
DQA_API dqa_status dqa_simulator_create(dqa_shape_space *space, const dqa_simulator_options *options,
                                        dqa_simulator **simulator);
/* NULL: nothing happens. Tapes of the simulator keep what they need of it. */
DQA_API void dqa_simulator_free(dqa_simulator *simulator);
/* New design: density, active cells, muscles, factor; resets the state to rest at the origin and the clock to 0.
 * weights [n_bases] on the simplex (>= 0, sum 1 within 1e-9). On failure the old design stays. */
DQA_API dqa_status dqa_simulator_set_weights(dqa_simulator *simulator, const double *weights, int64_t m,
                                             dqa_progress progress, void *user_data);

/* Young's modulus and muscle stiffness (Pa) by cell of the full box, each [n_cells] with n = n_cells of
 * dqa_shape_space_info, in place of the options' uniform values; NULL keeps or brings back the uniform one. Values must
 * be > 0 (young_modulus) and >= 0 (muscle_stiffness); cells scale them by their occupancy. For this design, which is
 * assembled anew from the density it has (state at rest, clock at 0), and for later ones. */
DQA_API dqa_status dqa_simulator_set_material(dqa_simulator *simulator, const double *young_modulus,
                                              const double *muscle_stiffness, int64_t n);
/* Nodes of the full box that keep their place: indices [n] of node (i, j, k) = (i * (cells_y + 1) + j) * (cells_z + 1) +
 * k, in two dimensions i * (cells_y + 1) + j. Those that a design does not have are ignored; n == 0 frees all. Applies
 * as dqa_simulator_set_material does. */
DQA_API dqa_status dqa_simulator_set_fixed_nodes(dqa_simulator *simulator, const int32_t *nodes, int64_t n);
/* Index in the full box of each node of the design [n_nodes]. */
DQA_API dqa_status dqa_simulator_node_box_index(const dqa_simulator *simulator, int32_t *nodes, int64_t n);

/* Velocity of the water (m/s) from a table instead of options.current, for the steps from here on: linear in time
 * between velocities [n_times][dims] at times [n_times] (s, strictly increasing), constant before and after; n =
 * n_times * dims. Time is that of dqa_simulator_info. Each step takes the value at its start. n_times == 0 goes back to
 * options.current. The arrays are copied; a new design keeps the table. */
DQA_API dqa_status dqa_simulator_set_current_table(dqa_simulator *simulator, const double *times, int64_t n_times,
                                                   const double *velocities, int64_t n);
/* Velocity of the water at `time` (s): writes current [dims] (m/s), zero on entry. Non-zero cancels the step. */
typedef int32_t (*dqa_current)(double time, double *current, void *user_data);
/* Receives current_bar [dims] = dL/d(current) of the step that began at `time`, for parameters of the caller's own.
 * Non-zero cancels the sweep after that step. */
typedef int32_t (*dqa_current_pullback)(double time, const double *current_bar, void *user_data);
/* The same from a function of the caller's, called once a step on the calling thread. The tape records its values: a
 * step that is recomputed does not ask again. During dqa_adjoint_backward `pullback` (NULL: not wanted) is called once
 * for every step, last step first. Both must stay callable, and user_data valid, while the simulator or a tape with
 * such steps is used. NULL current goes back to options.current. */
DQA_API dqa_status dqa_simulator_set_current_callback(dqa_simulator *simulator, dqa_current current,
                                                      dqa_current_pullback pullback, void *user_data);

/* What dqa_simulator_get_info tells; fields that need a design are 0 before dqa_simulator_set_weights. */
typedef struct dqa_simulator_info {
    uint32_t struct_size;
    int32_t dims;  /* 2 or 3 */
    int32_t n_bases;  /* length of the weights */
    int32_t n_signals;  /* actuation signals a step */
    int32_t n_sensors;          /* length of the sensor vector of dqa_simulator_sensors */
    int32_t has_design;         /* 0 or 1 */
    int64_t n_nodes;            /* of the active cells; state arrays have n_nodes * dims elements */
    int64_t n_active_cells;  /* simulated cells */
    int64_t n_body_cells;       /* cells whose density exceeds 1/2 */
    int64_t n_faces;            /* faces of the diffuse surface */
    int64_t n_muscle_cells;  /* cells with at least one fibre */
    int64_t factor_entries;     /* of the preconditioner's Cholesky factors */
    int64_t steps;              /* taken since the design was set or the state was last set */
    int64_t newton_iterations;  /* totals since the design was set */
    int64_t linear_iterations;  /* of conjugate gradients (factorisations with newton_direct) */
    int64_t adjoint_iterations;  /* of the backward sweeps of all its tapes */
    double time;                /* s: steps * time_step */
    double total_mass;          /* kg */
    double volume;              /* m^3: sum of occupancy times cell volume */
    double cell_size;           /* m */
    double last_residual;       /* relative force residual of the last step */
    double setup_seconds;       /* wall time of the last dqa_simulator_set_weights, barycentre included */
    double barycenter_seconds;  /* its barycentre alone */
} dqa_simulator_info;
/* `size` is sizeof(dqa_simulator_info) as the caller compiled it. */
DQA_API dqa_status dqa_simulator_get_info(const dqa_simulator *simulator, dqa_simulator_info *info, uint64_t size);
/* Current weights [n_bases]. */
DQA_API dqa_status dqa_simulator_get_weights(const dqa_simulator *simulator, double *weights, int64_t m);
/* The threshold for options.threshold that keeps the estimated error of leaving faint cells out at or below
 * `tolerance`, in (0, 1), at the design weights [n_bases]: the largest such in [1e-4, 0.499], or 0 (the full box)
 * where even 1e-4 leaves out too much. Writes it and, unless NULL, its estimate (of threshold 0: 0). The estimate is
 * of the displacements after ten steps: mass-weighted norm of their difference from those of the full box over the
 * norm of the latter. It is made from the density, without a step: the part of the bending stiffness of cross-sections
 * that the threshold takes away, as the root of its mean square over the body, times a factor calibrated on eels,
 * fish, orcas and rays at two widths of the kernel, so that measured errors are 0.3 to 0.65 of it, of rays 0.1.
 * Differences grow along a rollout: on an eel they reach the estimate after some sixty steps. Gradients are more
 * sensitive: the relative error by weights and actuation was 0.3 to 3 times the estimate at thresholds to 0.02, up to
 * 4 times above.
 * Moduli by cell, the floor of occupancy and whether the scene is planar are those of the simulator; neither it nor
 * its design changes, and its own threshold does not matter. The threshold is an option of the simulator and is not
 * chosen anew for each design: along an optimisation it must stay what it is, or the loss would jump where it changes
 * and no gradient would tell. Needs the density (seconds) unless `weights` are those of the present design.
 * DQA_ERROR_ARGUMENT for NULL, weights off the simplex or a tolerance outside (0, 1); nothing is written then. */
DQA_API dqa_status dqa_simulator_suggest_threshold(const dqa_simulator *simulator, const double *weights, int64_t m,
                                                   double tolerance, double *threshold, double *estimate);
/* One implicit Euler step with actuation [n_signals], each in [-1, 1]; appended to `tape` (NULL: not recorded).
 * On failure the state is that before the call. */
DQA_API dqa_status dqa_simulator_step(dqa_simulator *simulator, const double *actuation, int64_t n, dqa_tape *tape);
/* n_steps steps driven by a controller; appended to `tape` (NULL: not recorded). On failure or cancellation the state
 * is that after the last complete step, and the tape holds the complete steps. */
DQA_API dqa_status dqa_simulator_rollout(dqa_simulator *simulator, dqa_controller *controller, int64_t n_steps,
                                         dqa_tape *tape, dqa_progress progress, void *user_data);
/* Positions q and velocities v, each [n_nodes][dims] (m, m/s). NULL: not wanted. */
DQA_API dqa_status dqa_simulator_get_state(const dqa_simulator *simulator, double *q, int64_t nq, double *v,
                                           int64_t nv);
/* Sets the state and the clock to step 0. NULL q: rest positions; NULL v: zero. */
DQA_API dqa_status dqa_simulator_set_state(dqa_simulator *simulator, const double *q, int64_t nq, const double *v,
                                           int64_t nv);
/* What controllers see of the state, [n_sensors] = [5][dims], in the frame of the world: velocities of the head, centre
 * and tail sensors (m/s), then the offsets of the head and of the tail sensor from the centre sensor (m). Head and tail
 * sit where the density crosses half its peak on the sensor axis, centre at x = 0 (DiffAqua 2021, "Sensing"). */
DQA_API dqa_status dqa_simulator_sensors(const dqa_simulator *simulator, double *sensors, int64_t n);
/* Hydrodynamic totals of the last step, [4][dims]: drag force, thrust force (N, on the swimmer), then their means
 * weighted by face area (N/m^2 of wet surface). Zero before the first step. */
DQA_API dqa_status dqa_simulator_forces(const dqa_simulator *simulator, double *forces, int64_t n);
/* Isosurface of density at half its peak, carried by the current state: a closed triangle mesh, in two dimensions closed
 * polygons. Call with NULL buffers to learn the counts: n_vertices and n_elements receive them (rows; either may be
 * NULL). vertices [n_vertices][dims]; elements [n_elements][dims]: triangles, counter-clockwise seen from outside, or
 * segments with the body to their left. nv and ne count elements of the buffers. */
DQA_API dqa_status dqa_simulator_surface(const dqa_simulator *simulator, double *vertices, int64_t nv,
                                         int32_t *elements, int64_t ne, int64_t *n_vertices, int64_t *n_elements);
/* The simulated cells: nodes of each [n_active_cells][2^dims] (corner = 4 ix + 2 iy + iz; in two dimensions 2 ix + iy),
 * index of each in the box [n_active_cells], occupancy of each [n_active_cells] (> 0; 1 at the density's peak, a little
 * more above it). NULL: not wanted. */
DQA_API dqa_status dqa_simulator_mesh(const dqa_simulator *simulator, int32_t *cell_nodes, int64_t n_cell_nodes,
                                      int32_t *cell_box_index, int64_t n_cells, double *occupancy,
                                      int64_t n_occupancy);

/* An actuator of the current design, as the interpolation made it of those of the bases. */
typedef struct dqa_actuator_info {
    uint32_t struct_size;
    int32_t category;      /* in [0, 15] */
    int32_t kind;          /* DQA_ACTUATOR_* */
    int32_t side;          /* DQA_SIDE_* */
    int32_t layers;        /* of fins; 1 for caudal */
    int32_t n_signals;     /* of the category */
    int32_t first_signal;  /* of the category: its index among those of the space */
    int32_t padding;       /* 0 */
    double mean[3];        /* m */
    double covariance[9];  /* m^2, [3][3] */
    double half[3];        /* m: distances of the box's faces from the mean */
    double normal[9];      /* [3][3], a row per axis: unit normals of the faces */
    double edge[9];        /* [3][3], a row per axis: unit vectors along the edges; the normals in a rectangular box */
    double share;          /* sum of the weights of the bases that have the actuator */
    double strength;       /* factor of its muscles' stiffness: fades smoothly from 1 to 0 as share goes from 5 % to 0 */
} dqa_actuator_info;
/* What the interpolation made of an actuator in the current design. side: DQA_SIDE_BOTH for caudal categories,
 * DQA_SIDE_LEFT or DQA_SIDE_RIGHT for fins. DQA_ERROR_STATE where no base has it. */
DQA_API dqa_status dqa_simulator_actuator(const dqa_simulator *simulator, int32_t category, int32_t side,
                                          dqa_actuator_info *info, uint64_t size);
/* The muscle fibres of the current design, one row per active cell and fibre group: index of the cell among the active
 * ones, signal that drives it, sign (+1: contracts for a positive signal; -1: an antagonist) [n_muscles] each,
 * direction at rest [n_muscles][dims], and stiffness [n_muscles] (Pa: muscle_stiffness times occupancy, membership in
 * the actuator, its strength, and the group's share). Call with NULL buffers to learn the count, which *n_muscles
 * receives. NULL: not wanted; n counts elements of each of the first three, nd and ns of the others. */
DQA_API dqa_status dqa_simulator_muscles(const dqa_simulator *simulator, int32_t *cells, int32_t *signals,
                                         int32_t *signs, int64_t n, double *directions, int64_t nd,
                                         double *stiffness, int64_t ns, int64_t *n_muscles);

/* ------------------------------------------------------------------ controller */
/* Parameters theta and the map (sensors, step) -> actuation of that step, each signal in [-1, 1]. Recording a rollout
 * keeps a copy of the controller; changing it later does not change the tape. */

#define DQA_CONTROLLER_SINUSOID 0  /* dqa_controller_create_sinusoid */
#define DQA_CONTROLLER_MLP 1  /* dqa_controller_create_mlp */
#define DQA_CONTROLLER_CALLBACK 2  /* dqa_controller_create_callback */

/* Open loop: a sin(omega t + phi) per signal; parameters theta [n_signals][3] = (a in [0, 1], omega in rad/s, phi in
 * rad); t is the time at the start of a step. Initially a = 1, omega = pi / (6 time_step), phi = 0. */
DQA_API dqa_status dqa_controller_create_sinusoid(int32_t n_signals, double time_step, dqa_controller **controller);

/* Closed loop: a multilayer perceptron with tanh after every layer, the output included (DiffAqua 2021, "Closed-Loop
 * Controller"). Input: the 5 dims numbers of dqa_simulator_sensors, then, if temporal_encoding is 1, the 20 numbers
 *   sin(2^k pi tau), k = 0 ... 9, and cos(2^k pi tau), k = 0 ... 9,   tau = (step mod period_steps) / period_steps.
 * Parameters theta: for each layer weights [outputs][inputs], then biases [outputs]; with the defaults 7569 for 17
 * signals, 6529 for one. Initial weights are uniform in +-scale sqrt(6 / (inputs + outputs)), biases 0 (Glorot & Bengio
 * 2010); the same seed gives the same bits on every machine. */
typedef struct dqa_mlp_options {
    uint32_t struct_size;
    uint32_t flags;             /* must be 0 */
    int32_t n_signals;          /* outputs, in [1, 4096]; default 1 */
    int32_t dims;               /* of the simulator, 2 or 3; default 3 */
    int32_t n_hidden;           /* hidden layers, in [0, 5]; default 2 */
    int32_t hidden[5];          /* neurons of each, in [1, 65536]; default 64, 64 */
    int32_t temporal_encoding;  /* 1 (default) or 0 */
    int32_t period_steps;       /* period of the temporal encoding in steps, >= 1; default 25 */
    uint64_t seed;              /* of the initial weights; default 1 */
    double scale;               /* factor on the initial weights, >= 0; default 1 */
} dqa_mlp_options;
/* Fills *options with defaults; `size` is sizeof(dqa_mlp_options) as the caller compiled it. */
DQA_API dqa_status dqa_mlp_options_init(dqa_mlp_options *options, uint64_t size);
/* A perceptron with initial weights from the seed. */
DQA_API dqa_status dqa_controller_create_mlp(const dqa_mlp_options *options, dqa_controller **controller);

/* The caller's own controller. Writes actuation [n_signals], each in [-1, 1], of step `step` (time = step * time_step,
 * s) from sensors [n_sensors] (as of dqa_simulator_sensors at the start of the step; NULL when n_sensors is 0) and theta
 * [n_parameters]. Returns 0; anything else stops the call with DQA_CANCELLED and a message that names the callback. An
 * actuation outside of [-1, 1] or not finite is DQA_ERROR_ARGUMENT. It must depend on its arguments alone: the backward
 * sweep asks for derivatives in reverse order. */
typedef int32_t (*dqa_control_evaluate)(int64_t step, double time, const double *sensors, int64_t n_sensors,
                                        const double *theta, int64_t n_parameters, double *actuation, int64_t n_signals,
                                        void *user_data);
/* Its pullback: with J the derivative of actuation, writes theta_bar [n_parameters] = J_theta^T actuation_bar and
 * sensors_bar [n_sensors] = J_sensors^T actuation_bar; both arrive zeroed. Returns as dqa_control_evaluate. */
typedef int32_t (*dqa_control_pullback)(int64_t step, double time, const double *sensors, int64_t n_sensors,
                                        const double *theta, int64_t n_parameters, const double *actuation_bar,
                                        int64_t n_signals, double *theta_bar, double *sensors_bar, void *user_data);
/* A controller of the caller's own. */
typedef struct dqa_callback_controller_options {
    uint32_t struct_size;
    uint32_t flags;                /* must be 0 */
    int32_t n_signals;             /* in [1, 4096]; default 1 */
    int32_t n_sensors;             /* 0 (default): reads none, the loop is open; otherwise 5 dims, i.e. 15 or 10 */
    double time_step;              /* s, in [1e-12, 1e12]: only for the callbacks' `time`; default 1/30 */
    dqa_control_evaluate evaluate; /* not NULL */
    /* NULL: no derivatives. An open loop then still gives every gradient but DQA_WRT_CONTROL; a controller that reads
     * sensors closes a loop whose derivative is unknown, and dqa_adjoint_create refuses its tapes (DQA_ERROR_STATE). */
    dqa_control_pullback pullback;
    void *user_data;  /* given to both callbacks */
} dqa_callback_controller_options;
/* Fills *options with defaults; `size` is sizeof(dqa_callback_controller_options) as the caller compiled it. */
DQA_API dqa_status dqa_callback_controller_options_init(dqa_callback_controller_options *options, uint64_t size);
/* theta [n_parameters]: initial parameters, copied (NULL with n_parameters = 0: none). The callbacks and user_data must
 * live as long as the controller and the tapes and adjoints of its rollouts; they run on the thread of the call. */
DQA_API dqa_status dqa_controller_create_callback(const dqa_callback_controller_options *options, const double *theta,
                                                  int64_t n_parameters, dqa_controller **controller);
/* NULL: nothing happens. Tapes keep a copy of the controller that drove them. */
DQA_API void dqa_controller_free(dqa_controller *controller);

/* What dqa_controller_get_info tells. */
typedef struct dqa_controller_info {
    uint32_t struct_size;
    int32_t kind;           /* DQA_CONTROLLER_* */
    int32_t n_signals;  /* length of the actuation it writes */
    int32_t n_sensors;      /* length of the sensor vector it reads; 0: none */
    int32_t has_pullback;   /* 0 or 1 */
    int32_t padding;  /* 0 */
    int64_t n_parameters;  /* length of theta */
} dqa_controller_info;
/* `size` is sizeof(dqa_controller_info) as the caller compiled it. */
DQA_API dqa_status dqa_controller_get_info(const dqa_controller *controller, dqa_controller_info *info, uint64_t size);
/* *n receives the number of parameters. */
DQA_API dqa_status dqa_controller_n_parameters(const dqa_controller *controller, int64_t *n);
/* Copies the parameters to theta [n_parameters]. */
DQA_API dqa_status dqa_controller_get_parameters(const dqa_controller *controller, double *theta, int64_t n);
/* Replaces the parameters by theta [n_parameters]; DQA_ERROR_ARGUMENT where one is out of its range. */
DQA_API dqa_status dqa_controller_set_parameters(dqa_controller *controller, const double *theta, int64_t n);
/* Actuation [n] = [n_signals] at a step index (>= 0), e.g. for the caller's own loop over dqa_simulator_step. sensors
 * [n_sensors] as of dqa_simulator_sensors; NULL with 0 for a controller that reads none. On failure actuation keeps its
 * values. */
DQA_API dqa_status dqa_controller_evaluate(const dqa_controller *controller, int64_t step, const double *sensors,
                                           int64_t n_sensors, double *actuation, int64_t n);
/* Writes settings and parameters (atomically: a temporary file, then rename) and reads them back with the same bits. A
 * callback controller cannot be saved (DQA_ERROR_UNSUPPORTED); a file that is none or is damaged is DQA_ERROR_FILE. */
DQA_API dqa_status dqa_controller_save(const dqa_controller *controller, const char *path);
/* The controller of a file written by dqa_controller_save. */
DQA_API dqa_status dqa_controller_load(const char *path, dqa_controller **controller);

/* ------------------------------------------------------------------ tape */
/* What a tape may hold of a rollout: of its design, controller parameters, states and actuations. */
typedef struct dqa_tape_options {
    uint32_t struct_size;
    uint32_t flags;          /* must be 0 */
    /* Budget for recorded inputs and states; 0: unlimited (default). Beyond it the tape keeps every 2nd, 4th, 8th ...
     * state in half of it and computes the others again when they are asked for, with the same bits and without asking
     * a controller again; every adjoint then holds states of its own, in as much as the other half. Fewer bytes than
     * four states (positions and velocities of one, twice as much with BDF2), 168 bytes a step and its actuations are
     * DQA_ERROR_MEMORY.
     * Seeds of the caller's own and working memory of the solver are not counted. */
    int64_t memory_bytes;
} dqa_tape_options;
/* Fills *options with defaults; `size` is sizeof(dqa_tape_options) as the caller compiled it. */
DQA_API dqa_status dqa_tape_options_init(dqa_tape_options *options, uint64_t size);
/* An empty tape for the simulator's rollouts; the first recorded step fixes design and initial state. */
DQA_API dqa_status dqa_tape_create(dqa_simulator *simulator, const dqa_tape_options *options, dqa_tape **tape);
/* NULL: nothing happens. Adjoints of the tape keep what they need of it. */
DQA_API void dqa_tape_free(dqa_tape *tape);
/* Empties the tape for another rollout. DQA_ERROR_STATE while an adjoint of it lives. */
DQA_API dqa_status dqa_tape_clear(dqa_tape *tape);
/* *n_steps receives the number of recorded steps. */
DQA_API dqa_status dqa_tape_n_steps(const dqa_tape *tape, int64_t *n_steps);
/* State after `step` steps, step in [0, n_steps]; q, v [n_nodes][dims]. NULL: not wanted. States that a memory budget
 * made the tape drop are computed again: cheapest in order, from the first to the last. */
DQA_API dqa_status dqa_tape_get_state(dqa_tape *tape, int64_t step, double *q, int64_t nq, double *v, int64_t nv);
/* Actuation [n_signals] used in step `step`, in [0, n_steps). */
DQA_API dqa_status dqa_tape_get_actuation(dqa_tape *tape, int64_t step, double *actuation, int64_t n);
/* Velocity of the water [dims] during step `step`, in [0, n_steps). */
DQA_API dqa_status dqa_tape_get_current(dqa_tape *tape, int64_t step, double *current, int64_t n);
/* Vertices of the isosurface [n_vertices][dims] carried by the state after `step` steps; triangles as in
 * dqa_simulator_surface for the same design. */
DQA_API dqa_status dqa_tape_get_surface(dqa_tape *tape, int64_t step, double *vertices, int64_t nv);

/* What dqa_tape_stats tells. */
typedef struct dqa_tape_statistics {
    uint32_t struct_size;
    int32_t padding;  /* 0 */
    int64_t steps;  /* recorded */
    int64_t bytes;               /* held by recorded states and actuations */
    int64_t newton_iterations;   /* of the recorded steps */
    int64_t linear_iterations;  /* of the recorded steps */
    int64_t adjoint_iterations;  /* of all backward sweeps so far */
    double worst_residual;       /* largest relative force residual of the recorded steps */
    double worst_adjoint_residual;  /* largest relative residual of the adjoint's linear solves */
    int64_t checkpoints;         /* states held by the tape: steps + 1 while all of them are */
    int64_t recomputed_steps;    /* steps computed again by backward sweeps and reads so far */
    int64_t rescued_steps;       /* recorded steps in which the method of the options failed and another one, slower and
                                    for the same equations, found the answer */
    int64_t indefinite_steps;    /* recorded steps that met negative curvature on their way: their energy is not convex,
                                    and another equilibrium than the one found may exist. */
} dqa_tape_statistics;
/* `size` is sizeof(dqa_tape_statistics) as the caller compiled it. */
DQA_API dqa_status dqa_tape_stats(const dqa_tape *tape, dqa_tape_statistics *statistics, uint64_t size);

/* Terms of a loss. Steps i = 1 ... N of the tape end at state i; c, h, t are the places of the centre, head and tail
 * sensors (m), |x| stands for sqrt(x^2 + epsilon^2) - epsilon, which is smooth. */
/* -(mean over the spine of x_N - x_0), weighted by rest occupancy (m; DiffAqua 2021, section 8.1) */
#define DQA_OBJECTIVE_TRAVEL 0
/* sum_i [ sum over coordinates of |c_i - target| - gamma (h_i - t_i).x ]  (m; section 8.2, position keeping) */
#define DQA_OBJECTIVE_POSITION_KEEPING 1
/* -sum_i |P_t| / (1 + |P_t| + |P_d|), with P_t, P_d the products of thrust and drag of step i over wet area (N/m^2) with
 * the mean velocity of the spine at state i (m/s), weighted by rest occupancy (section 8.3; at most 0). Needs water. */
#define DQA_OBJECTIVE_EFFICIENCY 2
/* time_step * sum over steps and signals of actuation^2  (s) */
#define DQA_OBJECTIVE_EFFORT 3
/* sum_i |c_i - p(time of state i)|, the distance of the centre sensor from a point that moves along a polyline (m) */
#define DQA_OBJECTIVE_PATH 4

/* One term of a loss. An array of them has terms[0].struct_size as its stride. */
typedef struct dqa_objective_term {
    uint32_t struct_size;
    int32_t kind;       /* DQA_OBJECTIVE_* */
    double weight;      /* the loss is the weighted sum of the terms; default 1 */
    double target[3];   /* m: of POSITION_KEEPING (two coordinates in 2-D); default the origin */
    double gamma;       /* weight of the heading in POSITION_KEEPING; default 0.01 */
    double epsilon;     /* > 0: rounds |x|; m, for EFFICIENCY W/m^2; default 1e-4 */
    /* Of PATH: rows of (time in s on the simulator's clock, coordinates in m), times increasing; straight between the
     * rows, at rest before the first and after the last. [n_points][1 + dims], copied by every call. */
    const double *path;
    int64_t n_path;     /* elements of path */
} dqa_objective_term;
/* Fills *term with defaults (weight 1); `size` is sizeof(dqa_objective_term) as the caller compiled it. */
DQA_API dqa_status dqa_objective_term_init(dqa_objective_term *term, uint64_t size);
/* Loss of the recorded rollout, and each unweighted term [n_terms] (NULL: not wanted). */
DQA_API dqa_status dqa_tape_objective(dqa_tape *tape, const dqa_objective_term *terms, int64_t n_terms, double *loss,
                                      double *per_term);

/* ------------------------------------------------------------------ adjoint */
#define DQA_SEED_POSITION 0 /* dL/dq of the state after a step */
#define DQA_SEED_VELOCITY 1 /* dL/dv of the state after a step */

#define DQA_WRT_WEIGHTS 0          /* [n_bases], mean-free */
#define DQA_WRT_CONTROL 1          /* [n_parameters] of the controller of the rollout */
#define DQA_WRT_ACTUATION 2        /* [n_steps][n_signals], of numbers added to each actuation: a closed loop reacts */
#define DQA_WRT_INITIAL_POSITION 3 /* [n_nodes][dims] */
#define DQA_WRT_INITIAL_VELOCITY 4 /* [n_nodes][dims] */
#define DQA_WRT_WATER 5            /* [dims + 9]: a uniform velocity added to the current of every step [dims], the
                                      water's density, drag_coefficients [4], thrust_coefficients [4]; zero without
                                      water */
#define DQA_WRT_CURRENT 6          /* [n_steps][dims]: the current of each step */
#define DQA_WRT_CURRENT_TABLE 7    /* [n_times][dims]: velocities of dqa_simulator_set_current_table (one row, of
                                      options.current, without a table). DQA_ERROR_STATE unless all steps of the tape
                                      were taken with that one table */

#define DQA_WRT_YOUNGS_MODULUS 8    /* [n_cells] of the full box: the solid's E of each cell, Poisson's ratio held (1/Pa) */
#define DQA_WRT_MUSCLE_STIFFNESS 9  /* [n_cells] of the full box: the muscle stiffness of each cell (1/Pa) */
#define DQA_WRT_MATERIAL 10         /* [4]: E of all cells together, muscle stiffness of all cells together, Poisson's
                                       ratio (E held), density */
#define DQA_WRT_LAME 11             /* [2]: mu and lambda of all cells together, each with the other held (1/Pa) */

/* A cursor over a finished tape, standing after its last step. DQA_ERROR_STATE if a controller without pullback closed a
 * loop through the sensors. */
DQA_API dqa_status dqa_adjoint_create(dqa_tape *tape, dqa_adjoint **adjoint);
/* NULL: nothing happens. */
DQA_API void dqa_adjoint_free(dqa_adjoint *adjoint);
/* Adds `bar` [n_nodes][dims] to the seed of a quantity of the state after `step` steps. DQA_ERROR_STATE if the sweep
 * has passed that step. */
DQA_API dqa_status dqa_adjoint_seed(dqa_adjoint *adjoint, int64_t step, int32_t quantity, const double *bar, int64_t n);
/* Adds the seeds of an objective, its dependence on the design included. Only before the sweep has begun. */
DQA_API dqa_status dqa_adjoint_seed_objective(dqa_adjoint *adjoint, const dqa_objective_term *terms, int64_t n_terms);
/* Runs the sweep back to the state after `to_step` steps (0: all the way); resumable after cancellation. */
DQA_API dqa_status dqa_adjoint_backward(dqa_adjoint *adjoint, int64_t to_step, dqa_progress progress, void *user_data);
/* Reads a gradient. All but ACTUATION and CURRENT need the sweep to have reached step 0. */
DQA_API dqa_status dqa_adjoint_get(dqa_adjoint *adjoint, int32_t with_respect_to, double *out, int64_t n);

/* ------------------------------------------------------------------ proof of the gradient */
/* What to prove, and how far. */
typedef struct dqa_gradient_check_options {
    uint32_t struct_size;
    uint32_t flags;            /* must be 0 */
    int32_t with_respect_to;   /* DQA_WRT_* */
    int32_t n_steps;           /* length of the rollout; default 10 */
    uint64_t seed;             /* of the random direction; default 1 */
    double step;               /* largest finite-difference step relative to the quantity's scale; 0: automatic */
} dqa_gradient_check_options;
/* Fills *options with defaults; `size` is sizeof(dqa_gradient_check_options) as the caller compiled it. */
DQA_API dqa_status dqa_gradient_check_options_init(dqa_gradient_check_options *options, uint64_t size);

/* What dqa_check_gradient found. */
typedef struct dqa_gradient_check_report {
    uint32_t struct_size;
    int32_t one_sided;          /* 1 when the weights stand at the simplex's edge and differences were one-sided */
    double adjoint;             /* directional derivative by the adjoint */
    double finite_difference;   /* the same by the best step of the five-point ladder */
    double relative_error;      /* |adjoint - finite_difference| / |finite_difference| */
    double taylor_slope;        /* of |L(x + e d) - L(x) - e dL.d| over e: 2 for a correct gradient */
    double gradient_norm;       /* 2-norm of the gradient */
    double step;                /* the step of the best difference */
} dqa_gradient_check_report;
/* Proves (or refutes) the gradient of the objective of a rollout from the simulator's current state by finite
 * differences along one random direction. Runs with its own tight tolerances on a copy; the simulator is unchanged.
 * `controller` may be NULL (then actuations alternate smoothly with amplitude 1/2). With a controller, ACTUATION means
 * numbers added to what it says, in every step, while it goes on reacting. */
DQA_API dqa_status dqa_check_gradient(const dqa_simulator *simulator, const dqa_controller *controller,
                                      const dqa_objective_term *terms, int64_t n_terms,
                                      const dqa_gradient_check_options *options, dqa_gradient_check_report *report,
                                      uint64_t report_size);

/* ------------------------------------------------------------------ stateless helpers for optimisers */
/* One Adam step (Kingma & Ba 2015; beta1 0.9, beta2 0.999, eps 1e-8). x, gradient, rates, first_moment,
 * second_moment: [n]; iteration counts from 1; x and the moments are updated in place. DQA_DIVERGED where one of them would
 * be no finite number (gradients beyond 1e150 have no square); nothing has changed then. */
DQA_API dqa_status dqa_adam_step(double *x, const double *gradient, const double *rates, double *first_moment,
                                 double *second_moment, int64_t n, int64_t iteration);
/* Euclidean projection of x [n] onto the simplex, in place (Held, Wolfe & Crowder 1974). */
DQA_API dqa_status dqa_project_simplex(double *x, int64_t n);

/* ------------------------------------------------------------------ search without gradients */
/* CMA-ES: minimises a function of n numbers from its values alone (N. Hansen, "The CMA Evolution Strategy: A Tutorial",
 * arXiv 1604.00772, with full covariance, negative weights and all default constants). The caller evaluates, where and
 * how it likes: ask for the candidates of a generation, tell their values, and so on. The same options, seed and values
 * give the same candidates to the bit, also after saving and loading.
 *
 * Unknowns are free: bounds are the caller's. The usual way is to evaluate the nearest point within them and to tell
 * its value plus a multiple of the squared distance to it, so that there is always a way back (section B.5). Weights
 * of bases are searched as n_bases free numbers in the same way, with dqa_project_simplex as the nearest point. */
typedef struct dqa_cma_es dqa_cma_es;

/* How to search. */
typedef struct dqa_cma_es_options {
    uint32_t struct_size;
    uint32_t flags;       /* must be 0 */
    int64_t population;   /* candidates a generation, >= 2, with n * population <= 2^26; 0 (default): 4 + floor(3 ln n).
                             More find better minima of functions with many, at more evaluations */
    uint64_t seed;        /* of the normal numbers; default 1 */
    double sigma;         /* > 0: first standard deviation, in units of the scales; default 0.3. About a third of the
                             range in which the minimum is expected */
} dqa_cma_es_options;
/* Fills *options with defaults; `size` is sizeof(dqa_cma_es_options) as the caller compiled it. */
DQA_API dqa_status dqa_cma_es_options_init(dqa_cma_es_options *options, uint64_t size);
/* A search that starts at mean [n], n in [1, 2048]. scales [n], each > 0: what counts as one unit of each unknown
 * (NULL: 1). Both are copied. */
DQA_API dqa_status dqa_cma_es_create(const dqa_cma_es_options *options, const double *mean, const double *scales,
                                     int64_t n, dqa_cma_es **search);
/* NULL: nothing happens. */
DQA_API void dqa_cma_es_free(dqa_cma_es *search);
/* Candidates [population][n] of this generation; asking again before telling gives the same ones. count = population *
 * n. DQA_DIVERGED when the step size has grown until they overflow. */
DQA_API dqa_status dqa_cma_es_ask(dqa_cma_es *search, double *candidates, int64_t count);
/* Values [population] of the candidates in their order, none of them NaN or -infinity; +infinity for what could not be
 * evaluated. Ends the generation. DQA_ERROR_STATE unless they were asked for. DQA_DIVERGED when the covariance overflows: that
 * search is over. */
DQA_API dqa_status dqa_cma_es_tell(dqa_cma_es *search, const double *values, int64_t population);
/* The candidate of the lowest value so far, x [n], and that value; either may be NULL: not wanted. DQA_ERROR_STATE
 * before a finite value was told. */
DQA_API dqa_status dqa_cma_es_best(const dqa_cma_es *search, double *x, int64_t n, double *value);
/* Centre [n] of the distribution, where candidates are drawn about: often better than any of them. */
DQA_API dqa_status dqa_cma_es_mean(const dqa_cma_es *search, double *mean, int64_t n);

/* What dqa_cma_es_get_info tells. */
typedef struct dqa_cma_es_info {
    uint32_t struct_size;
    int32_t asked;        /* 1: candidates wait for their values */
    int64_t n;            /* unknowns */
    int64_t population;   /* candidates a generation */
    int64_t generation;   /* finished ones */
    int64_t evaluations;  /* values told */
    double sigma;         /* step size, in units of the scales */
    double widest;        /* largest standard deviation of an unknown, in units of its scale: small when converged */
    double axis_ratio;    /* longest over shortest axis of the distribution: above 1e7 it is no longer well defined */
} dqa_cma_es_info;
/* `size` is sizeof(dqa_cma_es_info) as the caller compiled it. */
DQA_API dqa_status dqa_cma_es_get_info(const dqa_cma_es *search, dqa_cma_es_info *info, uint64_t size);
/* Writes the state (atomically: a temporary file, then rename) and reads it back with the same bits. Candidates that
 * wait for their values are not in the file: asked for again, they are the same. */
DQA_API dqa_status dqa_cma_es_save(const dqa_cma_es *search, const char *path);
/* The search of a file written by dqa_cma_es_save; DQA_ERROR_FILE if it is none, is damaged or of a later version. */
DQA_API dqa_status dqa_cma_es_load(const char *path, dqa_cma_es **search);

#ifdef __cplusplus
}
#endif
#endif /* DIFFAQUA_H */
