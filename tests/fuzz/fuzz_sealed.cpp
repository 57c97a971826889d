// SPDX-License-Identifier: MIT
// Fuzzing of what the library saves: shape spaces, controllers, searches. A good file is edited as the bytes say and
// its checksum made right again, because damage by chance is found by that alone. Whatever is in the file, loading it
// is an error, or an object that works.
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "bytes.hpp"
#include "diffaqua.h"
#include "grid/file.hpp"

namespace {

void need(dqa_status status) {
    if (status == DQA_SUCCESS) return;
    std::fprintf(stderr, "set-up failed: %s\n", dqa_last_error());
    std::abort();
}

std::string content_of(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    const std::string content((std::istreambuf_iterator<char>(file)), {});
    std::filesystem::remove(path);
    return content;
}

dqa_shape_space* new_space(int dims) {
    dqa_shape_space_options o;
    need(dqa_shape_space_options_init(&o, sizeof o));
    o.dims = dims, o.cells_x = 12, o.cells_y = 8, o.cells_z = 8, o.sigma = 0.8, o.cell_size = 0.1,
    o.max_iterations = 50;
    dqa_shape_space* space = nullptr;
    need(dqa_shape_space_create(&o, &space));
    const int layers = dims == 3 ? 8 : 1;
    for (int base = 0; base < 2; ++base) {
        std::vector<double> cells;
        for (int i = 0; i < 12; ++i)
            for (int j = 0; j < 8; ++j)
                for (int k = 0; k < layers; ++k) {
                    const double x = i - 5.5, y = j - 3.5, z = layers > 1 ? k - 3.5 : 0.0;
                    cells.push_back(x * x / 25 + y * y / (4 + base) + z * z / 6 < 1 ? 1.0 : 0.0);
                }
        need(
            dqa_shape_space_add_density(space, "body", cells.data(), static_cast<std::int64_t>(cells.size()), nullptr));
    }
    dqa_actuator_options fins;
    need(dqa_actuator_options_init(&fins, sizeof fins));
    fins.category = 3, fins.kind = DQA_ACTUATOR_FINS, fins.layers = 1;
    for (int k = 0; k < 3; ++k) fins.mean[k] = 0.05 * k, fins.variance[k] = 0.01;
    need(dqa_shape_space_add_actuator(space, 1, &fins));
    need(dqa_shape_space_build(space, nullptr, nullptr));
    return space;
}

// One good file of each kind.
std::vector<std::string> good_files() {
    const std::string path =
        (std::filesystem::temp_directory_path() / ("fuzz-sealed-" + std::to_string(getpid()))).string();
    std::vector<std::string> files;
    for (const int dims : {2, 3}) {
        dqa_shape_space* space = new_space(dims);
        need(dqa_shape_space_save(space, path.c_str()));
        files.push_back(content_of(path));
        dqa_shape_space_free(space);
    }
    dqa_controller* controller = nullptr;
    need(dqa_controller_create_sinusoid(3, 0.02, &controller));
    need(dqa_controller_save(controller, path.c_str()));
    files.push_back(content_of(path));
    dqa_controller_free(controller);
    dqa_mlp_options mlp;
    need(dqa_mlp_options_init(&mlp, sizeof mlp));
    mlp.n_hidden = 1, mlp.hidden[0] = 4, mlp.n_signals = 2;
    need(dqa_controller_create_mlp(&mlp, &controller));
    need(dqa_controller_save(controller, path.c_str()));
    files.push_back(content_of(path));
    dqa_controller_free(controller);
    const double mean[3] = {0.1, 0.2, 0.3};
    std::array<double, 30> x{}, values{};
    dqa_cma_es* search = nullptr;
    need(dqa_cma_es_create(nullptr, mean, nullptr, 3, &search));
    need(dqa_cma_es_ask(search, x.data(), 3 * 7));
    need(dqa_cma_es_tell(search, values.data(), 7));
    need(dqa_cma_es_save(search, path.c_str()));
    files.push_back(content_of(path));
    dqa_cma_es_free(search);
    return files;
}

std::string edited(std::string file, fuzz::Bytes& in) {
    file.resize(file.size() - 8);  // its checksum
    while (!in.over()) {
        const int edit = in.below(6);
        std::size_t at = static_cast<std::size_t>(in.byte()) + 256 * static_cast<std::size_t>(in.byte());
        at = file.empty() ? 0 : at % file.size();
        const std::size_t left = file.size() - at;
        if (edit == 0 && left > 0) {
            file[at] = static_cast<char>(in.byte());
        } else if (edit == 1 && left >= 8) {
            const double value = in.number();
            std::memcpy(&file[at], &value, 8);
        } else if (edit == 2 && left >= 8) {
            const std::int64_t value = in.integer();
            std::memcpy(&file[at], &value, 8);
        } else if (edit == 3 && left >= 4) {
            const std::int32_t value = static_cast<std::int32_t>(in.integer());
            std::memcpy(&file[at], &value, 4);
        } else if (edit == 4) {
            file.erase(at, static_cast<std::size_t>(in.byte()));
        } else {
            file.insert(at, static_cast<std::size_t>(in.byte()), '\0');
        }
    }
    const std::uint64_t hash = dqa::fnv1a(file, file.size());
    return file.append(reinterpret_cast<const char*>(&hash), sizeof hash);
}

void use(dqa_shape_space* space) {
    dqa_shape_space_info info;
    need(dqa_shape_space_get_info(space, &info, sizeof info));
    if (info.n_cells > 4096) return;  // time, not danger
    std::vector<double> weights(static_cast<std::size_t>(info.n_bases), 1.0 / info.n_bases);
    std::vector<double> cells(static_cast<std::size_t>(info.n_cells));
    (void)dqa_shape_space_density(space, weights.data(), info.n_bases, cells.data(), info.n_cells);
    dqa_simulator* simulator = nullptr;
    if (dqa_simulator_create(space, nullptr, &simulator) != DQA_SUCCESS) return;
    (void)dqa_simulator_set_weights(simulator, weights.data(), info.n_bases, nullptr, nullptr);
    dqa_simulator_free(simulator);
}

void use(dqa_controller* controller) {
    dqa_controller_info info;
    need(dqa_controller_get_info(controller, &info, sizeof info));
    std::vector<double> sensors(static_cast<std::size_t>(info.n_sensors), 0.1);
    std::vector<double> signals(static_cast<std::size_t>(info.n_signals));
    (void)dqa_controller_evaluate(controller, 7, sensors.data(), info.n_sensors, signals.data(), info.n_signals);
}

void use(dqa_cma_es* search) {
    dqa_cma_es_info info;
    need(dqa_cma_es_get_info(search, &info, sizeof info));
    if (info.n * info.population > 4096) return;
    std::vector<double> x(static_cast<std::size_t>(info.n * info.population));
    const std::vector<double> values(static_cast<std::size_t>(info.population), 1.0);
    (void)dqa_cma_es_ask(search, x.data(), info.n * info.population);
    (void)dqa_cma_es_tell(search, values.data(), info.population);
}

// A file without an edit must load: else the seal is wrong, and everything else is refused for that alone.
bool loaded(dqa_status status, bool whole) {
    if (whole) need(status);
    return status == DQA_SUCCESS;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const std::vector<std::string> files = good_files();
    fuzz::Bytes in(data, size);
    const int kind = in.below(static_cast<int>(files.size()));
    const bool whole = in.over();
    const fuzz::MemoryFile file(edited(files[static_cast<std::size_t>(kind)], in));
    if (kind < 2) {
        dqa_shape_space* space = nullptr;
        if (loaded(dqa_shape_space_load(file.path(), &space), whole)) use(space);
        dqa_shape_space_free(space);
    } else if (kind < 4) {
        dqa_controller* controller = nullptr;
        if (loaded(dqa_controller_load(file.path(), &controller), whole)) use(controller);
        dqa_controller_free(controller);
    } else {
        dqa_cma_es* search = nullptr;
        if (loaded(dqa_cma_es_load(file.path(), &search), whole)) use(search);
        dqa_cma_es_free(search);
    }
    return 0;
}
