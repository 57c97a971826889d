/* SPDX-License-Identifier: MIT
 * Size and field offsets of every public struct, frozen for the x86-64 LP64 ABI. A line here changes only together
 * with DQA_ABI_VERSION; a new field comes after the last one and changes the size alone. */
#include <stddef.h>

#include "support.h"

#if defined(__x86_64__) && defined(__LP64__)

#define SIZE(type, bytes)                                                 \
    _Static_assert(sizeof(type) == (bytes), "size of " #type " changed"); \
    _Static_assert(sizeof(type) % 8 == 0, #type " has hidden padding at its end");
#define AT(type, field, bytes) _Static_assert(offsetof(type, field) == (bytes), #type "." #field " moved");

/* clang-format off: one field a line */
SIZE(dqa_shape_space_options, 112)
AT(dqa_shape_space_options, struct_size, 0)
AT(dqa_shape_space_options, flags, 4)
AT(dqa_shape_space_options, dims, 8)
AT(dqa_shape_space_options, cells_x, 12)
AT(dqa_shape_space_options, cells_y, 16)
AT(dqa_shape_space_options, cells_z, 20)
AT(dqa_shape_space_options, margin, 24)
AT(dqa_shape_space_options, margin_across, 28)
AT(dqa_shape_space_options, up, 32)
AT(dqa_shape_space_options, subsamples, 36)
AT(dqa_shape_space_options, peak, 40)
AT(dqa_shape_space_options, max_iterations, 44)
AT(dqa_shape_space_options, threads, 48)
AT(dqa_shape_space_options, padding, 52)
AT(dqa_shape_space_options, body_length, 56)
AT(dqa_shape_space_options, cell_size, 64)
AT(dqa_shape_space_options, sigma, 72)
AT(dqa_shape_space_options, tolerance, 80)
AT(dqa_shape_space_options, cancel, 88)
AT(dqa_shape_space_options, interpolation, 96)
AT(dqa_shape_space_options, automatic_fins, 100)
AT(dqa_shape_space_options, refinement, 104)

SIZE(dqa_actuator_options, 96)
AT(dqa_actuator_options, struct_size, 0)
AT(dqa_actuator_options, flags, 4)
AT(dqa_actuator_options, category, 8)
AT(dqa_actuator_options, kind, 12)
AT(dqa_actuator_options, mean, 16)
AT(dqa_actuator_options, variance, 40)
AT(dqa_actuator_options, euler, 64)
AT(dqa_actuator_options, side, 88)
AT(dqa_actuator_options, layers, 92)

SIZE(dqa_shape_space_info, 48)
AT(dqa_shape_space_info, struct_size, 0)
AT(dqa_shape_space_info, dims, 4)
AT(dqa_shape_space_info, cells_x, 8)
AT(dqa_shape_space_info, cells_y, 12)
AT(dqa_shape_space_info, cells_z, 16)
AT(dqa_shape_space_info, n_bases, 20)
AT(dqa_shape_space_info, n_signals, 24)
AT(dqa_shape_space_info, is_built, 28)
AT(dqa_shape_space_info, n_cells, 32)
AT(dqa_shape_space_info, cell_size, 40)

SIZE(dqa_signal_info, 24)
AT(dqa_signal_info, struct_size, 0)
AT(dqa_signal_info, category, 4)
AT(dqa_signal_info, kind, 8)
AT(dqa_signal_info, layer, 12)
AT(dqa_signal_info, group, 16)
AT(dqa_signal_info, padding, 20)

SIZE(dqa_simulator_options, 280)
AT(dqa_simulator_options, struct_size, 0)
AT(dqa_simulator_options, flags, 4)
AT(dqa_simulator_options, threads, 8)
AT(dqa_simulator_options, method, 12)
AT(dqa_simulator_options, water, 16)
AT(dqa_simulator_options, max_newton, 20)
AT(dqa_simulator_options, max_linear, 24)
AT(dqa_simulator_options, instruction_set, 28)
AT(dqa_simulator_options, integrator, 32)
AT(dqa_simulator_options, material, 36)
AT(dqa_simulator_options, planar, 40)
AT(dqa_simulator_options, preconditioner, 44)
AT(dqa_simulator_options, time_step, 48)
AT(dqa_simulator_options, young_modulus, 56)
AT(dqa_simulator_options, poisson_ratio, 64)
AT(dqa_simulator_options, density, 72)
AT(dqa_simulator_options, muscle_stiffness, 80)
AT(dqa_simulator_options, contraction, 88)
AT(dqa_simulator_options, threshold, 96)
AT(dqa_simulator_options, occupancy_floor, 104)
AT(dqa_simulator_options, tolerance, 112)
AT(dqa_simulator_options, adjoint_tolerance, 120)
AT(dqa_simulator_options, water_density, 128)
AT(dqa_simulator_options, current, 136)
AT(dqa_simulator_options, drag_coefficients, 160)
AT(dqa_simulator_options, thrust_coefficients, 192)
AT(dqa_simulator_options, speed_smoothing, 224)
AT(dqa_simulator_options, angle_smoothing, 232)
AT(dqa_simulator_options, surface_smoothing, 240)
AT(dqa_simulator_options, cancel, 248)
AT(dqa_simulator_options, water_faces, 256)
AT(dqa_simulator_options, linear_precision, 260)
AT(dqa_simulator_options, quadrature, 264)
AT(dqa_simulator_options, padding, 268)
AT(dqa_simulator_options, max_products, 272)

SIZE(dqa_simulator_info, 160)
AT(dqa_simulator_info, struct_size, 0)
AT(dqa_simulator_info, dims, 4)
AT(dqa_simulator_info, n_bases, 8)
AT(dqa_simulator_info, n_signals, 12)
AT(dqa_simulator_info, n_sensors, 16)
AT(dqa_simulator_info, has_design, 20)
AT(dqa_simulator_info, n_nodes, 24)
AT(dqa_simulator_info, n_active_cells, 32)
AT(dqa_simulator_info, n_body_cells, 40)
AT(dqa_simulator_info, n_faces, 48)
AT(dqa_simulator_info, n_muscle_cells, 56)
AT(dqa_simulator_info, factor_entries, 64)
AT(dqa_simulator_info, steps, 72)
AT(dqa_simulator_info, newton_iterations, 80)
AT(dqa_simulator_info, linear_iterations, 88)
AT(dqa_simulator_info, adjoint_iterations, 96)
AT(dqa_simulator_info, time, 104)
AT(dqa_simulator_info, total_mass, 112)
AT(dqa_simulator_info, volume, 120)
AT(dqa_simulator_info, cell_size, 128)
AT(dqa_simulator_info, last_residual, 136)
AT(dqa_simulator_info, setup_seconds, 144)
AT(dqa_simulator_info, barycenter_seconds, 152)

SIZE(dqa_actuator_info, 312)
AT(dqa_actuator_info, struct_size, 0)
AT(dqa_actuator_info, category, 4)
AT(dqa_actuator_info, kind, 8)
AT(dqa_actuator_info, side, 12)
AT(dqa_actuator_info, layers, 16)
AT(dqa_actuator_info, n_signals, 20)
AT(dqa_actuator_info, first_signal, 24)
AT(dqa_actuator_info, padding, 28)
AT(dqa_actuator_info, mean, 32)
AT(dqa_actuator_info, covariance, 56)
AT(dqa_actuator_info, half, 128)
AT(dqa_actuator_info, normal, 152)
AT(dqa_actuator_info, edge, 224)
AT(dqa_actuator_info, share, 296)
AT(dqa_actuator_info, strength, 304)

SIZE(dqa_mlp_options, 64)
AT(dqa_mlp_options, struct_size, 0)
AT(dqa_mlp_options, flags, 4)
AT(dqa_mlp_options, n_signals, 8)
AT(dqa_mlp_options, dims, 12)
AT(dqa_mlp_options, n_hidden, 16)
AT(dqa_mlp_options, hidden, 20)
AT(dqa_mlp_options, temporal_encoding, 40)
AT(dqa_mlp_options, period_steps, 44)
AT(dqa_mlp_options, seed, 48)
AT(dqa_mlp_options, scale, 56)

SIZE(dqa_callback_controller_options, 48)
AT(dqa_callback_controller_options, struct_size, 0)
AT(dqa_callback_controller_options, flags, 4)
AT(dqa_callback_controller_options, n_signals, 8)
AT(dqa_callback_controller_options, n_sensors, 12)
AT(dqa_callback_controller_options, time_step, 16)
AT(dqa_callback_controller_options, evaluate, 24)
AT(dqa_callback_controller_options, pullback, 32)
AT(dqa_callback_controller_options, user_data, 40)

SIZE(dqa_controller_info, 32)
AT(dqa_controller_info, struct_size, 0)
AT(dqa_controller_info, kind, 4)
AT(dqa_controller_info, n_signals, 8)
AT(dqa_controller_info, n_sensors, 12)
AT(dqa_controller_info, has_pullback, 16)
AT(dqa_controller_info, padding, 20)
AT(dqa_controller_info, n_parameters, 24)

SIZE(dqa_tape_options, 16)
AT(dqa_tape_options, struct_size, 0)
AT(dqa_tape_options, flags, 4)
AT(dqa_tape_options, memory_bytes, 8)

SIZE(dqa_tape_statistics, 96)
AT(dqa_tape_statistics, struct_size, 0)
AT(dqa_tape_statistics, padding, 4)
AT(dqa_tape_statistics, steps, 8)
AT(dqa_tape_statistics, bytes, 16)
AT(dqa_tape_statistics, newton_iterations, 24)
AT(dqa_tape_statistics, linear_iterations, 32)
AT(dqa_tape_statistics, adjoint_iterations, 40)
AT(dqa_tape_statistics, worst_residual, 48)
AT(dqa_tape_statistics, worst_adjoint_residual, 56)
AT(dqa_tape_statistics, checkpoints, 64)
AT(dqa_tape_statistics, recomputed_steps, 72)
AT(dqa_tape_statistics, rescued_steps, 80)
AT(dqa_tape_statistics, indefinite_steps, 88)

SIZE(dqa_objective_term, 72)
AT(dqa_objective_term, struct_size, 0)
AT(dqa_objective_term, kind, 4)
AT(dqa_objective_term, weight, 8)
AT(dqa_objective_term, target, 16)
AT(dqa_objective_term, gamma, 40)
AT(dqa_objective_term, epsilon, 48)
AT(dqa_objective_term, path, 56)
AT(dqa_objective_term, n_path, 64)

SIZE(dqa_gradient_check_options, 32)
AT(dqa_gradient_check_options, struct_size, 0)
AT(dqa_gradient_check_options, flags, 4)
AT(dqa_gradient_check_options, with_respect_to, 8)
AT(dqa_gradient_check_options, n_steps, 12)
AT(dqa_gradient_check_options, seed, 16)
AT(dqa_gradient_check_options, step, 24)

SIZE(dqa_gradient_check_report, 56)
AT(dqa_gradient_check_report, struct_size, 0)
AT(dqa_gradient_check_report, one_sided, 4)
AT(dqa_gradient_check_report, adjoint, 8)
AT(dqa_gradient_check_report, finite_difference, 16)
AT(dqa_gradient_check_report, relative_error, 24)
AT(dqa_gradient_check_report, taylor_slope, 32)
AT(dqa_gradient_check_report, gradient_norm, 40)
AT(dqa_gradient_check_report, step, 48)

SIZE(dqa_cma_es_options, 32)
AT(dqa_cma_es_options, struct_size, 0)
AT(dqa_cma_es_options, flags, 4)
AT(dqa_cma_es_options, population, 8)
AT(dqa_cma_es_options, seed, 16)
AT(dqa_cma_es_options, sigma, 24)

SIZE(dqa_cma_es_info, 64)
AT(dqa_cma_es_info, struct_size, 0)
AT(dqa_cma_es_info, asked, 4)
AT(dqa_cma_es_info, n, 8)
AT(dqa_cma_es_info, population, 16)
AT(dqa_cma_es_info, generation, 24)
AT(dqa_cma_es_info, evaluations, 32)
AT(dqa_cma_es_info, sigma, 40)
AT(dqa_cma_es_info, widest, 48)
AT(dqa_cma_es_info, axis_ratio, 56)
/* clang-format on */

#endif

/* The library was compiled with the layout that this program sees. */
static void sizes_agree(void** state) {
    dqa_shape_space_options space;
    dqa_simulator_options simulator;
    dqa_actuator_options actuator;
    dqa_tape_options tape;
    dqa_objective_term term;
    dqa_gradient_check_options check;
    dqa_cma_es_options search;
    (void)state;
    ok(dqa_shape_space_options_init(&space, sizeof space));
    ok(dqa_simulator_options_init(&simulator, sizeof simulator));
    ok(dqa_actuator_options_init(&actuator, sizeof actuator));
    ok(dqa_tape_options_init(&tape, sizeof tape));
    ok(dqa_objective_term_init(&term, sizeof term));
    ok(dqa_gradient_check_options_init(&check, sizeof check));
    ok(dqa_cma_es_options_init(&search, sizeof search));
    assert_int_equal(space.struct_size, sizeof space);
    assert_int_equal(simulator.struct_size, sizeof simulator);
    assert_int_equal(actuator.struct_size, sizeof actuator);
    assert_int_equal(tape.struct_size, sizeof tape);
    assert_int_equal(term.struct_size, sizeof term);
    assert_int_equal(check.struct_size, sizeof check);
    assert_int_equal(search.struct_size, sizeof search);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(sizes_agree)};
    return cmocka_run_group_tests_name("abi_layout", tests, NULL, NULL);
}
