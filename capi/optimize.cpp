// SPDX-License-Identifier: MIT
// The handle of the search without gradients.
#include <cinttypes>
#include <cmath>
#include <limits>

#include "internal.hpp"
#include "optimize/cma_es.hpp"

using namespace dqa::capi;
using dqa::CmaEs;
using dqa::fail;
using dqa::Status;

struct dqa_cma_es : dqa::capi::Handle {
    std::unique_ptr<CmaEs> core;
};

namespace {

dqa_cma_es_options default_options() {
    const dqa::CmaEsSettings s;
    dqa_cma_es_options o{};
    o.struct_size = sizeof o;
    o.population = s.population;
    o.seed = s.seed;
    o.sigma = s.sigma;
    return o;
}

void give(std::unique_ptr<CmaEs> core, dqa_cma_es** search) {
    auto made = std::make_unique<dqa_cma_es>();
    made->core = std::move(core);
    *search = made.release();
}

}  // namespace

extern "C" {

dqa_status dqa_cma_es_options_init(dqa_cma_es_options* options, uint64_t size) {
    return guard([&] { init_options(options, size, default_options(), "options"); });
}

dqa_status dqa_cma_es_create(const dqa_cma_es_options* options, const double* mean, const double* scales, int64_t n,
                             dqa_cma_es** search) {
    return guard([&] {
        begin_create(search, "search");
        const auto o = read_options(options, default_options(), "options");
        require_range(o.flags, o.flags == 0, "flags", "0");
        if (n < 1 || n > CmaEs::most_unknowns)
            fail(Status::ERROR_ARGUMENT, "n is %" PRId64 ", expected a number in [1, %d]", n, CmaEs::most_unknowns);
        require(mean, "mean"), require_finite(mean, n, "mean");
        if (o.population != 0 && (o.population < 2 || o.population > CmaEs::most_numbers / n))
            fail(Status::ERROR_ARGUMENT,
                 "population is %" PRId64 ", expected 0 or a number in [2, %" PRId64 "] for %" PRId64 " unknowns",
                 o.population, CmaEs::most_numbers / n, n);
        require_range(o.sigma, o.sigma > 0, "sigma", "a number > 0");
        std::vector<double> units(static_cast<std::size_t>(n), 1.0);
        if (scales) {
            require_finite(scales, n, "scales");
            for (int64_t i = 0; i < n; ++i)
                if (!(scales[i] > 0))
                    fail(Status::ERROR_ARGUMENT, "scales[%" PRId64 "] is %g, expected a number > 0", i, scales[i]);
            units.assign(scales, scales + n);
        }
        dqa::CmaEsSettings s;
        s.n = static_cast<int>(n), s.population = static_cast<int>(o.population);
        s.seed = o.seed, s.sigma = o.sigma;
        give(std::make_unique<CmaEs>(s, mean, units.data()), search);
    });
}

void dqa_cma_es_free(dqa_cma_es* search) {
    free_handle(search);
}

dqa_status dqa_cma_es_ask(dqa_cma_es* search, double* candidates, int64_t count) {
    return guard([&] {
        const Change change(search, "search");
        require(candidates, "candidates");
        CmaEs& core = *search->core;
        require_count(count, int64_t{core.population()} * core.n(), "count", "candidates [population][n]");
        core.ask(candidates);
    });
}

dqa_status dqa_cma_es_tell(dqa_cma_es* search, const double* values, int64_t population) {
    return guard([&] {
        const Change change(search, "search");
        require(values, "values");
        CmaEs& core = *search->core;
        require_count(population, core.population(), "population", "values [population]");
        for (int64_t k = 0; k < population; ++k)
            if (std::isnan(values[k]) || values[k] == -std::numeric_limits<double>::infinity())
                fail(Status::ERROR_ARGUMENT, "values[%" PRId64 "] is %g, expected a number or +infinity", k, values[k]);
        core.tell(values);
    });
}

dqa_status dqa_cma_es_best(const dqa_cma_es* search, double* x, int64_t n, double* value) {
    return guard([&] {
        require(search, "search");
        const CmaEs& core = *search->core;
        if (core.best().empty())
            fail(Status::ERROR_STATE, "search has no best candidate yet: no finite value was told");
        if (x) copy_out(core.best().data(), core.best().size(), x, n, "n", "x [n]");
        if (value) *value = core.best_value();
    });
}

dqa_status dqa_cma_es_mean(const dqa_cma_es* search, double* mean, int64_t n) {
    return guard([&] {
        require(search, "search"), require(mean, "mean");
        copy_out(search->core->mean().data(), search->core->mean().size(), mean, n, "n", "mean [n]");
    });
}

dqa_status dqa_cma_es_get_info(const dqa_cma_es* search, dqa_cma_es_info* info, uint64_t size) {
    return guard([&] {
        require(search, "search");
        const CmaEs& core = *search->core;
        dqa_cma_es_info i{};
        i.asked = core.asked() ? 1 : 0;
        i.n = core.n(), i.population = core.population();
        i.generation = core.generation();
        i.evaluations = i.generation * i.population;
        i.sigma = core.sigma(), i.widest = core.widest(), i.axis_ratio = core.axis_ratio();
        write_struct(info, size, i, "info");
    });
}

dqa_status dqa_cma_es_save(const dqa_cma_es* search, const char* path) {
    return guard([&] {
        require(search, "search"), require(path, "path");
        search->core->save(path);
    });
}

dqa_status dqa_cma_es_load(const char* path, dqa_cma_es** search) {
    return guard([&] {
        begin_create(search, "search");
        require(path, "path");
        give(CmaEs::load(path), search);
    });
}

}  // extern "C"
