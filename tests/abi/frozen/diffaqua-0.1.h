/* SPDX-License-Identifier: MIT
 * The header of version 0.1.0 without its comments, made by freeze.py: never edited by hand. */
#ifndef DIFFAQUA_H
#define DIFFAQUA_H

#include <stdint.h>

#if defined(__GNUC__) && !defined(DQA_NO_VISIBILITY)
#define DQA_API __attribute__((visibility("default")))
#else
#define DQA_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

#define DQA_VERSION_MAJOR 0
#define DQA_VERSION_MINOR 1
#define DQA_VERSION_PATCH 0
#define DQA_ABI_VERSION 0

typedef int32_t dqa_status;
#define DQA_SUCCESS 0
#define DQA_ERROR_ARGUMENT (-1)
#define DQA_ERROR_STATE (-2)
#define DQA_ERROR_FILE (-3)
#define DQA_ERROR_IO (-4)
#define DQA_ERROR_MESH (-5)
#define DQA_ERROR_MEMORY (-6)
#define DQA_ERROR_UNSUPPORTED (-7)
#define DQA_NOT_CONVERGED (-8)
#define DQA_DIVERGED (-9)
#define DQA_CANCELLED (-10)
#define DQA_ERROR_INTERNAL (-11)

DQA_API const char *dqa_version(void);

DQA_API int32_t dqa_abi_version(void);

DQA_API const char *dqa_features(void);

DQA_API const char *dqa_status_name(dqa_status status);

DQA_API const char *dqa_status_text(dqa_status status);

DQA_API const char *dqa_last_error(void);

#define DQA_LOG_ERROR 1
#define DQA_LOG_WARNING 2
#define DQA_LOG_INFO 3
#define DQA_LOG_DEBUG 4

typedef void (*dqa_log_handler)(int32_t level, const char *message, void *user_data);

DQA_API dqa_status dqa_set_log_handler(dqa_log_handler handler, int32_t level, void *user_data);

typedef int32_t (*dqa_progress)(int64_t done, int64_t total, void *user_data);

typedef struct dqa_cancel_token dqa_cancel_token;

DQA_API dqa_status dqa_cancel_token_create(dqa_cancel_token **token);

DQA_API dqa_status dqa_cancel_token_set(dqa_cancel_token *token);

DQA_API dqa_status dqa_cancel_token_reset(dqa_cancel_token *token);

DQA_API void dqa_cancel_token_free(dqa_cancel_token *token);

typedef struct dqa_shape_space dqa_shape_space;

#define DQA_PEAK_SMOOTH 0
#define DQA_PEAK_PAPER 1

#define DQA_UP_AUTO 0
#define DQA_UP_Z 1
#define DQA_UP_Y 2

#define DQA_INTERPOLATION_LINEAR 0
#define DQA_INTERPOLATION_BURES 1

typedef struct dqa_shape_space_options {
    uint32_t struct_size;
    uint32_t flags;
    int32_t dims;
    int32_t cells_x;
    int32_t cells_y;
    int32_t cells_z;
    int32_t margin;
    int32_t margin_across;
    int32_t up;
    int32_t subsamples;
    int32_t peak;
    int32_t max_iterations;
    int32_t threads;
    int32_t padding;
    double body_length;
    double cell_size;
    double sigma;
    double tolerance;
    dqa_cancel_token *cancel;
    int32_t interpolation;
    int32_t automatic_fins;
} dqa_shape_space_options;

DQA_API dqa_status dqa_shape_space_options_init(dqa_shape_space_options *options, uint64_t size);

DQA_API dqa_status dqa_shape_space_create(const dqa_shape_space_options *options, dqa_shape_space **space);

DQA_API void dqa_shape_space_free(dqa_shape_space *space);

DQA_API dqa_status dqa_shape_space_add_mesh(dqa_shape_space *space, const char *name, const double *vertices,
                                            int64_t n_vertices, const int32_t *triangles, int64_t n_triangles,
                                            int32_t *base);

DQA_API dqa_status dqa_shape_space_add_mesh_file(dqa_shape_space *space, const char *path, int32_t *base);

DQA_API dqa_status dqa_shape_space_add_density(dqa_shape_space *space, const char *name, const double *cells, int64_t n,
                                               int32_t *base);

DQA_API dqa_status dqa_shape_space_add_polygon(dqa_shape_space *space, const char *name, const double *corners,
                                               int64_t n_corners, int32_t *base);

DQA_API dqa_status dqa_shape_space_add_image(dqa_shape_space *space, const char *name, const double *pixels,
                                             int64_t n_rows, int64_t n_columns, int32_t *base);

#define DQA_ACTUATOR_CAUDAL 0
#define DQA_ACTUATOR_FINS 1

#define DQA_SIDE_BOTH 0
#define DQA_SIDE_LEFT 1
#define DQA_SIDE_RIGHT 2

typedef struct dqa_actuator_options {
    uint32_t struct_size;
    uint32_t flags;
    int32_t category;
    int32_t kind;
    double mean[3];
    double variance[3];
    double euler[3];
    int32_t side;
    int32_t layers;
} dqa_actuator_options;

DQA_API dqa_status dqa_actuator_options_init(dqa_actuator_options *options, uint64_t size);

DQA_API dqa_status dqa_shape_space_add_actuator(dqa_shape_space *space, int32_t base,
                                                const dqa_actuator_options *options);

DQA_API dqa_status dqa_shape_space_get_actuator(const dqa_shape_space *space, int32_t base, int32_t category,
                                                int32_t side, dqa_actuator_options *options);

DQA_API dqa_status dqa_shape_space_build(dqa_shape_space *space, dqa_progress progress, void *user_data);

typedef struct dqa_shape_space_info {
    uint32_t struct_size;
    int32_t dims;
    int32_t cells_x;
    int32_t cells_y;
    int32_t cells_z;
    int32_t n_bases;
    int32_t n_signals;
    int32_t is_built;
    int64_t n_cells;
    double cell_size;
} dqa_shape_space_info;

DQA_API dqa_status dqa_shape_space_get_info(const dqa_shape_space *space, dqa_shape_space_info *info, uint64_t size);

typedef struct dqa_signal_info {
    uint32_t struct_size;
    int32_t category;
    int32_t kind;
    int32_t layer;
    int32_t group;
    int32_t padding;
} dqa_signal_info;

DQA_API dqa_status dqa_shape_space_signal(const dqa_shape_space *space, int32_t signal, dqa_signal_info *info,
                                          uint64_t size);

DQA_API const char *dqa_shape_space_base_name(const dqa_shape_space *space, int32_t base);

DQA_API dqa_status dqa_shape_space_get_base(const dqa_shape_space *space, int32_t base, double *cells, int64_t n);

DQA_API dqa_status dqa_shape_space_density(const dqa_shape_space *space, const double *weights, int64_t m,
                                           double *density, int64_t n);

DQA_API dqa_status dqa_shape_space_pullback(const dqa_shape_space *space, const double *weights, int64_t m,
                                            const double *density_bar, int64_t n, double *weights_bar);

DQA_API dqa_status dqa_shape_space_save(const dqa_shape_space *space, const char *path);

DQA_API dqa_status dqa_shape_space_load(const char *path, dqa_shape_space **space);

typedef struct dqa_simulator dqa_simulator;

typedef struct dqa_controller dqa_controller;

typedef struct dqa_tape dqa_tape;

typedef struct dqa_adjoint dqa_adjoint;

#define DQA_METHOD_NEWTON_PCG 0
#define DQA_METHOD_NEWTON_DIRECT 1

#define DQA_METHOD_PROJECTIVE 2

#define DQA_PRECONDITIONER_MULTILEVEL 0
#define DQA_PRECONDITIONER_FACTOR 1

#define DQA_PRECISION_SINGLE 0
#define DQA_PRECISION_DOUBLE 1

#define DQA_INTEGRATOR_IMPLICIT_EULER 0
#define DQA_INTEGRATOR_BDF2 1

#define DQA_MATERIAL_COROTATED 0
#define DQA_MATERIAL_COROTATED_VOLUME 1
#define DQA_MATERIAL_NEO_HOOKEAN 2

#define DQA_QUADRATURE_FULL 0
#define DQA_QUADRATURE_REDUCED 1

#define DQA_WATER_NONE 0
#define DQA_WATER_IMPLICIT 1
#define DQA_WATER_EXPLICIT 2

#define DQA_FACES_BOTH 0
#define DQA_FACES_WINDWARD 1

typedef struct dqa_simulator_options {
    uint32_t struct_size;
    uint32_t flags;
    int32_t threads;
    int32_t method;
    int32_t water;
    int32_t max_newton;
    int32_t max_linear;
    int32_t instruction_set;
    int32_t integrator;
    int32_t material;
    int32_t planar;
    int32_t preconditioner;
    double time_step;
    double young_modulus;
    double poisson_ratio;
    double density;
    double muscle_stiffness;
    double contraction;
    double threshold;
    double occupancy_floor;
    double tolerance;
    double adjoint_tolerance;
    double water_density;
    double current[3];
    double drag_coefficients[4];
    double thrust_coefficients[4];
    double speed_smoothing;
    double angle_smoothing;
    double surface_smoothing;
    dqa_cancel_token *cancel;
    int32_t water_faces;
    int32_t linear_precision;
    int32_t quadrature;
    int32_t padding;
} dqa_simulator_options;

DQA_API dqa_status dqa_simulator_options_init(dqa_simulator_options *options, uint64_t size);

DQA_API dqa_status dqa_simulator_create(dqa_shape_space *space, const dqa_simulator_options *options,
                                        dqa_simulator **simulator);

DQA_API void dqa_simulator_free(dqa_simulator *simulator);

DQA_API dqa_status dqa_simulator_set_weights(dqa_simulator *simulator, const double *weights, int64_t m,
                                             dqa_progress progress, void *user_data);

DQA_API dqa_status dqa_simulator_set_material(dqa_simulator *simulator, const double *young_modulus,
                                              const double *muscle_stiffness, int64_t n);

DQA_API dqa_status dqa_simulator_set_fixed_nodes(dqa_simulator *simulator, const int32_t *nodes, int64_t n);

DQA_API dqa_status dqa_simulator_node_box_index(const dqa_simulator *simulator, int32_t *nodes, int64_t n);

DQA_API dqa_status dqa_simulator_set_current_table(dqa_simulator *simulator, const double *times, int64_t n_times,
                                                   const double *velocities, int64_t n);

typedef int32_t (*dqa_current)(double time, double *current, void *user_data);

typedef int32_t (*dqa_current_pullback)(double time, const double *current_bar, void *user_data);

DQA_API dqa_status dqa_simulator_set_current_callback(dqa_simulator *simulator, dqa_current current,
                                                      dqa_current_pullback pullback, void *user_data);

typedef struct dqa_simulator_info {
    uint32_t struct_size;
    int32_t dims;
    int32_t n_bases;
    int32_t n_signals;
    int32_t n_sensors;
    int32_t has_design;
    int64_t n_nodes;
    int64_t n_active_cells;
    int64_t n_body_cells;
    int64_t n_faces;
    int64_t n_muscle_cells;
    int64_t factor_entries;
    int64_t steps;
    int64_t newton_iterations;
    int64_t linear_iterations;
    int64_t adjoint_iterations;
    double time;
    double total_mass;
    double volume;
    double cell_size;
    double last_residual;
    double setup_seconds;
    double barycenter_seconds;
} dqa_simulator_info;

DQA_API dqa_status dqa_simulator_get_info(const dqa_simulator *simulator, dqa_simulator_info *info, uint64_t size);

DQA_API dqa_status dqa_simulator_get_weights(const dqa_simulator *simulator, double *weights, int64_t m);

DQA_API dqa_status dqa_simulator_suggest_threshold(const dqa_simulator *simulator, const double *weights, int64_t m,
                                                   double tolerance, double *threshold, double *estimate);

DQA_API dqa_status dqa_simulator_step(dqa_simulator *simulator, const double *actuation, int64_t n, dqa_tape *tape);

DQA_API dqa_status dqa_simulator_rollout(dqa_simulator *simulator, dqa_controller *controller, int64_t n_steps,
                                         dqa_tape *tape, dqa_progress progress, void *user_data);

DQA_API dqa_status dqa_simulator_get_state(const dqa_simulator *simulator, double *q, int64_t nq, double *v,
                                           int64_t nv);

DQA_API dqa_status dqa_simulator_set_state(dqa_simulator *simulator, const double *q, int64_t nq, const double *v,
                                           int64_t nv);

DQA_API dqa_status dqa_simulator_sensors(const dqa_simulator *simulator, double *sensors, int64_t n);

DQA_API dqa_status dqa_simulator_forces(const dqa_simulator *simulator, double *forces, int64_t n);

DQA_API dqa_status dqa_simulator_surface(const dqa_simulator *simulator, double *vertices, int64_t nv,
                                         int32_t *elements, int64_t ne, int64_t *n_vertices, int64_t *n_elements);

DQA_API dqa_status dqa_simulator_mesh(const dqa_simulator *simulator, int32_t *cell_nodes, int64_t n_cell_nodes,
                                      int32_t *cell_box_index, int64_t n_cells, double *occupancy,
                                      int64_t n_occupancy);

typedef struct dqa_actuator_info {
    uint32_t struct_size;
    int32_t category;
    int32_t kind;
    int32_t side;
    int32_t layers;
    int32_t n_signals;
    int32_t first_signal;
    int32_t padding;
    double mean[3];
    double covariance[9];
    double half[3];
    double normal[9];
    double edge[9];
    double share;
    double strength;
} dqa_actuator_info;

DQA_API dqa_status dqa_simulator_actuator(const dqa_simulator *simulator, int32_t category, int32_t side,
                                          dqa_actuator_info *info, uint64_t size);

DQA_API dqa_status dqa_simulator_muscles(const dqa_simulator *simulator, int32_t *cells, int32_t *signals,
                                         int32_t *signs, int64_t n, double *directions, int64_t nd,
                                         double *stiffness, int64_t ns, int64_t *n_muscles);

#define DQA_CONTROLLER_SINUSOID 0
#define DQA_CONTROLLER_MLP 1
#define DQA_CONTROLLER_CALLBACK 2

DQA_API dqa_status dqa_controller_create_sinusoid(int32_t n_signals, double time_step, dqa_controller **controller);

typedef struct dqa_mlp_options {
    uint32_t struct_size;
    uint32_t flags;
    int32_t n_signals;
    int32_t dims;
    int32_t n_hidden;
    int32_t hidden[5];
    int32_t temporal_encoding;
    int32_t period_steps;
    uint64_t seed;
    double scale;
} dqa_mlp_options;

DQA_API dqa_status dqa_mlp_options_init(dqa_mlp_options *options, uint64_t size);

DQA_API dqa_status dqa_controller_create_mlp(const dqa_mlp_options *options, dqa_controller **controller);

typedef int32_t (*dqa_control_evaluate)(int64_t step, double time, const double *sensors, int64_t n_sensors,
                                        const double *theta, int64_t n_parameters, double *actuation, int64_t n_signals,
                                        void *user_data);

typedef int32_t (*dqa_control_pullback)(int64_t step, double time, const double *sensors, int64_t n_sensors,
                                        const double *theta, int64_t n_parameters, const double *actuation_bar,
                                        int64_t n_signals, double *theta_bar, double *sensors_bar, void *user_data);

typedef struct dqa_callback_controller_options {
    uint32_t struct_size;
    uint32_t flags;
    int32_t n_signals;
    int32_t n_sensors;
    double time_step;
    dqa_control_evaluate evaluate;

    dqa_control_pullback pullback;
    void *user_data;
} dqa_callback_controller_options;

DQA_API dqa_status dqa_callback_controller_options_init(dqa_callback_controller_options *options, uint64_t size);

DQA_API dqa_status dqa_controller_create_callback(const dqa_callback_controller_options *options, const double *theta,
                                                  int64_t n_parameters, dqa_controller **controller);

DQA_API void dqa_controller_free(dqa_controller *controller);

typedef struct dqa_controller_info {
    uint32_t struct_size;
    int32_t kind;
    int32_t n_signals;
    int32_t n_sensors;
    int32_t has_pullback;
    int32_t padding;
    int64_t n_parameters;
} dqa_controller_info;

DQA_API dqa_status dqa_controller_get_info(const dqa_controller *controller, dqa_controller_info *info, uint64_t size);

DQA_API dqa_status dqa_controller_n_parameters(const dqa_controller *controller, int64_t *n);

DQA_API dqa_status dqa_controller_get_parameters(const dqa_controller *controller, double *theta, int64_t n);

DQA_API dqa_status dqa_controller_set_parameters(dqa_controller *controller, const double *theta, int64_t n);

DQA_API dqa_status dqa_controller_evaluate(const dqa_controller *controller, int64_t step, const double *sensors,
                                           int64_t n_sensors, double *actuation, int64_t n);

DQA_API dqa_status dqa_controller_save(const dqa_controller *controller, const char *path);

DQA_API dqa_status dqa_controller_load(const char *path, dqa_controller **controller);

typedef struct dqa_tape_options {
    uint32_t struct_size;
    uint32_t flags;

    int64_t memory_bytes;
} dqa_tape_options;

DQA_API dqa_status dqa_tape_options_init(dqa_tape_options *options, uint64_t size);

DQA_API dqa_status dqa_tape_create(dqa_simulator *simulator, const dqa_tape_options *options, dqa_tape **tape);

DQA_API void dqa_tape_free(dqa_tape *tape);

DQA_API dqa_status dqa_tape_clear(dqa_tape *tape);

DQA_API dqa_status dqa_tape_n_steps(const dqa_tape *tape, int64_t *n_steps);

DQA_API dqa_status dqa_tape_get_state(dqa_tape *tape, int64_t step, double *q, int64_t nq, double *v, int64_t nv);

DQA_API dqa_status dqa_tape_get_actuation(dqa_tape *tape, int64_t step, double *actuation, int64_t n);

DQA_API dqa_status dqa_tape_get_current(dqa_tape *tape, int64_t step, double *current, int64_t n);

DQA_API dqa_status dqa_tape_get_surface(dqa_tape *tape, int64_t step, double *vertices, int64_t nv);

typedef struct dqa_tape_statistics {
    uint32_t struct_size;
    int32_t padding;
    int64_t steps;
    int64_t bytes;
    int64_t newton_iterations;
    int64_t linear_iterations;
    int64_t adjoint_iterations;
    double worst_residual;
    double worst_adjoint_residual;
    int64_t checkpoints;
    int64_t recomputed_steps;
    int64_t rescued_steps;
} dqa_tape_statistics;

DQA_API dqa_status dqa_tape_stats(const dqa_tape *tape, dqa_tape_statistics *statistics, uint64_t size);

#define DQA_OBJECTIVE_TRAVEL 0

#define DQA_OBJECTIVE_POSITION_KEEPING 1

#define DQA_OBJECTIVE_EFFICIENCY 2

#define DQA_OBJECTIVE_EFFORT 3

#define DQA_OBJECTIVE_PATH 4

typedef struct dqa_objective_term {
    uint32_t struct_size;
    int32_t kind;
    double weight;
    double target[3];
    double gamma;
    double epsilon;

    const double *path;
    int64_t n_path;
} dqa_objective_term;

DQA_API dqa_status dqa_objective_term_init(dqa_objective_term *term, uint64_t size);

DQA_API dqa_status dqa_tape_objective(dqa_tape *tape, const dqa_objective_term *terms, int64_t n_terms, double *loss,
                                      double *per_term);

#define DQA_SEED_POSITION 0
#define DQA_SEED_VELOCITY 1

#define DQA_WRT_WEIGHTS 0
#define DQA_WRT_CONTROL 1
#define DQA_WRT_ACTUATION 2
#define DQA_WRT_INITIAL_POSITION 3
#define DQA_WRT_INITIAL_VELOCITY 4
#define DQA_WRT_WATER 5
#define DQA_WRT_CURRENT 6
#define DQA_WRT_CURRENT_TABLE 7

#define DQA_WRT_YOUNGS_MODULUS 8
#define DQA_WRT_MUSCLE_STIFFNESS 9
#define DQA_WRT_MATERIAL 10
#define DQA_WRT_LAME 11

DQA_API dqa_status dqa_adjoint_create(dqa_tape *tape, dqa_adjoint **adjoint);

DQA_API void dqa_adjoint_free(dqa_adjoint *adjoint);

DQA_API dqa_status dqa_adjoint_seed(dqa_adjoint *adjoint, int64_t step, int32_t quantity, const double *bar, int64_t n);

DQA_API dqa_status dqa_adjoint_seed_objective(dqa_adjoint *adjoint, const dqa_objective_term *terms, int64_t n_terms);

DQA_API dqa_status dqa_adjoint_backward(dqa_adjoint *adjoint, int64_t to_step, dqa_progress progress, void *user_data);

DQA_API dqa_status dqa_adjoint_get(dqa_adjoint *adjoint, int32_t with_respect_to, double *out, int64_t n);

typedef struct dqa_gradient_check_options {
    uint32_t struct_size;
    uint32_t flags;
    int32_t with_respect_to;
    int32_t n_steps;
    uint64_t seed;
    double step;
} dqa_gradient_check_options;

DQA_API dqa_status dqa_gradient_check_options_init(dqa_gradient_check_options *options, uint64_t size);

typedef struct dqa_gradient_check_report {
    uint32_t struct_size;
    int32_t one_sided;
    double adjoint;
    double finite_difference;
    double relative_error;
    double taylor_slope;
    double gradient_norm;
    double step;
} dqa_gradient_check_report;

DQA_API dqa_status dqa_check_gradient(const dqa_simulator *simulator, const dqa_controller *controller,
                                      const dqa_objective_term *terms, int64_t n_terms,
                                      const dqa_gradient_check_options *options, dqa_gradient_check_report *report,
                                      uint64_t report_size);

DQA_API dqa_status dqa_adam_step(double *x, const double *gradient, const double *rates, double *first_moment,
                                 double *second_moment, int64_t n, int64_t iteration);

DQA_API dqa_status dqa_project_simplex(double *x, int64_t n);

typedef struct dqa_cma_es dqa_cma_es;

typedef struct dqa_cma_es_options {
    uint32_t struct_size;
    uint32_t flags;
    int64_t population;
    uint64_t seed;
    double sigma;
} dqa_cma_es_options;

DQA_API dqa_status dqa_cma_es_options_init(dqa_cma_es_options *options, uint64_t size);

DQA_API dqa_status dqa_cma_es_create(const dqa_cma_es_options *options, const double *mean, const double *scales,
                                     int64_t n, dqa_cma_es **search);

DQA_API void dqa_cma_es_free(dqa_cma_es *search);

DQA_API dqa_status dqa_cma_es_ask(dqa_cma_es *search, double *candidates, int64_t count);

DQA_API dqa_status dqa_cma_es_tell(dqa_cma_es *search, const double *values, int64_t population);

DQA_API dqa_status dqa_cma_es_best(const dqa_cma_es *search, double *x, int64_t n, double *value);

DQA_API dqa_status dqa_cma_es_mean(const dqa_cma_es *search, double *mean, int64_t n);

typedef struct dqa_cma_es_info {
    uint32_t struct_size;
    int32_t asked;
    int64_t n;
    int64_t population;
    int64_t generation;
    int64_t evaluations;
    double sigma;
    double widest;
    double axis_ratio;
} dqa_cma_es_info;

DQA_API dqa_status dqa_cma_es_get_info(const dqa_cma_es *search, dqa_cma_es_info *info, uint64_t size);

DQA_API dqa_status dqa_cma_es_save(const dqa_cma_es *search, const char *path);

DQA_API dqa_status dqa_cma_es_load(const char *path, dqa_cma_es **search);

#ifdef __cplusplus
}
#endif
#endif
