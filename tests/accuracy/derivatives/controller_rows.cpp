// SPDX-License-Identifier: MIT
// Rows of the controllers.
#include "control/perceptron.hpp"
#include "table.hpp"

namespace table {
namespace {

using namespace dqa;

void rows_of(Table& t, const std::string& stage, const Controller& controller, double scale) {
    derivative::Random random(6);
    std::vector<Field> fields{{"parameters", controller.parameters(), scale}};
    if (controller.n_sensors() > 0)
        fields.push_back({"sensors", random.vector(static_cast<std::size_t>(controller.n_sensors())), 0.1});
    const auto with = [&](const Inputs& x) {
        auto c = controller.clone();
        c->assign_parameters(x[0]);
        return c;
    };
    const auto seen = [](const Inputs& x) { return x.size() > 1 ? x[1].data() : nullptr; };
    // Signals at three times, the last one far from the start.
    constexpr long kTimes[] = {3, 17, 1000};
    const std::size_t n = static_cast<std::size_t>(controller.n_signals());
    t.prove(
        stage, fields,
        [&](const Inputs& x) {
            Vector out(3 * n);
            for (std::size_t k = 0; k < 3; ++k) with(x)->evaluate(kTimes[k], seen(x), &out[k * n]);
            return out;
        },
        [&](const Inputs& x, const Vector& bar) {
            Inputs out{Vector(x[0].size(), 0.0), Vector(static_cast<std::size_t>(controller.n_sensors()), 0.0)};
            for (std::size_t k = 0; k < 3; ++k)
                with(x)->pullback(kTimes[k], seen(x), &bar[k * n], out[0].data(), out[1].data());
            return out;
        });
}

}  // namespace

void controller_rows(Table& t) {
    Sinusoid sinusoid(2, 1.0 / 30.0);
    sinusoid.set_parameters({0.8, 11.0, 0.3, 0.5, 7.0, -1.0});
    rows_of(t, "sinusoid", sinusoid, 1e-3);
    PerceptronSettings s;
    s.n_signals = 3, s.hidden = {16, 12}, s.scale = 1.5;
    rows_of(t, "perceptron", Perceptron(s), 0.02);
    s.dims = 2, s.hidden = {8};
    rows_of(t, "perceptron, 2-D", Perceptron(s), 0.02);
}

}  // namespace table
