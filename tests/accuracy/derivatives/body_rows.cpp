// SPDX-License-Identifier: MIT
// Rows of the body's energies: every material and the muscles, by state and by parameters.
#include "body/fibre_turn.hpp"
#include "motion_fixtures.hpp"
#include "table.hpp"

namespace table {
namespace {

using namespace dqa;

// A block with moduli of its own in every cell, and fibres in several directions, some cells with two.
struct Block {
    ActiveSet set = fixtures::full_set({3, 3, 2}, 0.1);
    Vector rest = set.rest_positions(), mu, lambda, weights, directions, signals{0.3, -0.8};
    std::vector<MuscleEntry> muscles;

    Block() {
        derivative::Random random(3);
        const std::size_t n = static_cast<std::size_t>(set.n_cells());
        mu = random.vector(n, 2e5, 2e6), lambda = random.vector(n, 2e5, 4e6);
        for (int e = 0; e < 13; ++e) {
            MuscleEntry m;
            m.cell = (5 * e) % set.n_cells(), m.signal = e % 2, m.sign = e % 3 ? 1.0 : -1.0;
            Vector d = random.vector(3);
            const double size = derivative::norm(d);
            for (std::size_t k = 0; k < 3; ++k) directions.push_back(m.direction[k] = d[k] / size);
            weights.push_back(m.weight = random.uniform(5e5, 2e6));
            muscles.push_back(m);
        }
    }
    Vector displaced(double part) const {
        derivative::Random random(4);
        return derivative::along(rest, part * set.box.dx, random.vector(rest.size()));
    }
};

struct Forces {
    double energy = 0.0;
    Vector elastic, muscle;
    BodyWorkspace ws;
};

Forces forces_of(const Body& body, const Vector& q, const Vector& signals) {
    Forces out;
    out.elastic.resize(q.size()), out.muscle.resize(q.size());
    out.energy = body.gradient(out.ws, q.data(), signals.data(), 1, out.elastic.data(), out.muscle.data());
    return out;
}

Vector product_of(const Body& body, const Vector& q, const Vector& signals, const Vector& p) {
    Forces at = forces_of(body, q, signals);
    Vector out(q.size(), 0.0);
    body.product(at.ws, p.data(), 1, out.data());
    return out;
}

constexpr const char* kSymmetric = "J d is the Hessian's product: its symmetry";

void elastic_rows(Table& t, const std::string& name, Material material, Quadrature quadrature) {
    const Block b;
    const std::string stage = "body, " + name;
    const auto body_of = [&](const Inputs& x) {
        return Body(b.set, {material, x[1], x[2], quadrature}, {}, 0.2, InstructionSet::automatic);
    };
    const Inputs x{b.displaced(0.15), b.mu, b.lambda};
    t.prove(
        stage + ": energy", {{"state", x[0], 4e-3}},
        [&](const Inputs& in) {
            return Vector{forces_of(body_of({in[0], x[1], x[2]}), in[0], b.signals).energy};
        },
        [&](const Inputs& in, const Vector& bar) {
            return Inputs{derivative::along(Vector(in[0].size(), 0.0), bar[0],
                                            forces_of(body_of({in[0], x[1], x[2]}), in[0], b.signals).elastic)};
        });
    std::vector<Field> fields{{"state", x[0], 4e-3, false, kSymmetric}, {"μ of each cell", x[1], 1e5, true}};
    fields[0].product = [&](const Inputs& in, const Vector& d) {
        return product_of(body_of({in[0], x[1], x[2]}), in[0], b.signals, d);
    };
    if (material != Material::corotated) fields.push_back({"λ of each cell", x[2], 1e5, true});
    const auto full = [&](const Inputs& in) { return Inputs{in[0], in[1], in.size() > 2 ? in[2] : x[2]}; };
    t.prove(
        stage + ": forces", fields,
        [&](const Inputs& in) { return forces_of(body_of(full(in)), in[0], b.signals).elastic; },
        [&](const Inputs& in, const Vector& bar) {
            const Body body = body_of(full(in));
            Forces at = forces_of(body, in[0], b.signals);
            Vector mu_bar(b.mu.size(), 0.0), lambda_bar(mu_bar), none(2, 0.0);
            body.parameter_pullback(at.ws, in[0].data(), bar.data(), 1,
                                    {mu_bar.data(), lambda_bar.data(), nullptr, none.data()});
            return Inputs{product_of(body, in[0], b.signals, bar), mu_bar, lambda_bar};
        });
}

// One cell turned inside out along x and stretched unevenly: singular values 1.3, 1, -0.5, far from one another.
void inverted_rows(Table& t, const std::string& name, Quadrature quadrature) {
    const ActiveSet set = fixtures::full_set({1, 1, 1}, 0.1);
    const Body body(set, {Material::corotated, {1e6}, {}, quadrature}, {}, 0.2, InstructionSet::automatic);
    derivative::Random random(4);
    const Vector q = derivative::along(fixtures::mapped(set.rest_positions(), {-0.5, 0.1, 0, 0, 1.3, 0.1, 0.05, 0, 1}),
                                       0.002, random.vector(24));
    Field state{"state, a cell turned inside out", q, 2e-3, false, kSymmetric};
    state.product = [&](const Inputs& in, const Vector& d) { return product_of(body, in[0], {0.0}, d); };
    t.prove(
        "body, " + name + ": forces", {state}, [&](const Inputs& in) { return forces_of(body, in[0], {0.0}).elastic; },
        [&](const Inputs& in, const Vector& bar) { return Inputs{product_of(body, in[0], {0.0}, bar)}; });
}

void fibre_rows(Table& t) {
    const Block b;
    const Vector soft(b.mu.size(), 0.0);  // the muscles alone
    const auto fibres = [&](const Inputs& in) {
        std::vector<MuscleEntry> out = b.muscles;
        for (std::size_t e = 0; e < out.size(); ++e) {
            out[e].weight = in[2][e];
            for (std::size_t k = 0; k < 3; ++k) out[e].direction[k] = in[3][3 * e + k];
        }
        return out;
    };
    const auto body_of = [&](const Inputs& in) {
        return Body(b.set, {Material::corotated, soft, {}}, fibres(in), 0.2, InstructionSet::automatic);
    };
    const Inputs x{b.displaced(0.15), b.signals, b.weights, b.directions};
    t.prove(
        "body, muscles: energy", {{"state", x[0], 4e-3}},
        [&](const Inputs& in) { return Vector{forces_of(body_of(x), in[0], x[1]).energy}; },
        [&](const Inputs& in, const Vector& bar) {
            return Inputs{
                derivative::along(Vector(in[0].size(), 0.0), bar[0], forces_of(body_of(x), in[0], x[1]).muscle)};
        });
    std::vector<Field> fields{{"state", x[0], 4e-3, false, kSymmetric},
                              {"signals (rest ratios)", x[1], 0.2, true},
                              {"weight of each fibre", x[2], 1e5, true},
                              {"direction of each fibre", x[3], 0.02}};
    fields[0].product = [&](const Inputs& in, const Vector& d) { return product_of(body_of(in), in[0], in[1], d); };
    t.prove(
        "body, muscles: forces", fields, [&](const Inputs& in) { return forces_of(body_of(in), in[0], in[1]).muscle; },
        [&](const Inputs& in, const Vector& bar) {
            const Body body = body_of(in);
            Forces at = forces_of(body, in[0], in[1]);
            Vector mu_bar(b.mu.size(), 0.0), signal_bar(2, 0.0), weight_bar(in[2].size(), 0.0), direction_bar;
            body.parameter_pullback(at.ws, in[0].data(), bar.data(), 1,
                                    {mu_bar.data(), nullptr, weight_bar.data(), signal_bar.data()});
            std::vector<Vec3> turned(in[2].size(), Vec3{});
            add_direction_bar(b.set, fibres(in), 0.2, in[0].data(), bar.data(), in[1].data(), turned);
            for (const Vec3& d : turned) direction_bar.insert(direction_bar.end(), d.begin(), d.end());
            return Inputs{product_of(body, in[0], in[1], bar), signal_bar, weight_bar, direction_bar};
        });
}

}  // namespace

void body_rows(Table& t) {
    elastic_rows(t, "corotated", Material::corotated, Quadrature::full);
    inverted_rows(t, "corotated", Quadrature::full);
    elastic_rows(t, "corotated with volume term", Material::corotated_volume, Quadrature::full);
    elastic_rows(t, "neo-Hookean", Material::neo_hookean, Quadrature::full);
    fibre_rows(t);
}

void reduced_body_rows(Table& t) {
    elastic_rows(t, "corotated, one point", Material::corotated, Quadrature::reduced);
    inverted_rows(t, "corotated, one point", Quadrature::reduced);
    elastic_rows(t, "neo-Hookean, one point", Material::neo_hookean, Quadrature::reduced);
}

}  // namespace table
