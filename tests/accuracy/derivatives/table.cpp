// SPDX-License-Identifier: MIT
#include "table.hpp"

#include <limits>
#include <map>

namespace table {
namespace {

using derivative::along;
using derivative::dot;
using derivative::norm;

constexpr int kLevels = 9;  // of the ladder of steps, 2^-1 ... 2^-9 of the direction

// <w, f> along a direction, each point evaluated once.
class Line {
public:
    explicit Line(std::function<Vector(double)> f) : f_(std::move(f)) {}
    const Vector& at(double e) {
        const auto found = values_.find(e);
        return found != values_.end() ? found->second : values_.emplace(e, f_(e)).first->second;
    }

private:
    std::function<Vector(double)> f_;
    std::map<double, Vector> values_;
};

// Five-point differences of f along the direction, from long steps to short ones.
derivative::Samples ladder(Line& line, const Vector& d, bool one_sided) {
    derivative::Samples s{d, line.at(0.0), {}, {}};
    for (int k = one_sided ? 2 : 1; k <= kLevels; ++k) {
        const double e = std::ldexp(1.0, -k);
        const derivative::Map along_line = [&](const Vector& x) { return line.at(x[0]); };
        s.quotients.push_back(derivative::quotient(along_line, {0.0}, {1.0}, e, one_sided));
    }
    return s;
}

// |<w, f(e) - f(0)> - e slope|.
double remainder(Line& line, const Vector& w, double e, double slope) {
    return std::fabs(dot(w, along(line.at(e), -1.0, line.at(0.0))) - e * slope);
}

// Rounding of <w, f>: its change over steps too short for any curvature.
double rounding(Line& line, const Vector& w, double slope, bool one_sided) {
    double size = 0.0;
    for (std::size_t k = 0; k < w.size(); ++k) size = std::max(size, std::fabs(w[k] * line.at(0.0)[k]));
    double noise = 2e-16 * size;
    for (const double e : {1e-8, 2e-8, 3e-8})
        for (const double side : {1.0, -1.0})
            if (!one_sided || side > 0) noise = std::max(noise, remainder(line, w, side * e, slope));
    return noise;
}

}  // namespace

bool Row::passed() const {
    return (linear ? slope == 0.0 : std::fabs(slope - 2.0) <= 0.1) && differences <= 1e-6 && dot_product <= 1e-6;
}

Row Table::measure(const Field& field, std::size_t index, const Inputs& x, const Map& f,
                   const Pullback& pullback) const {
    Row row{"", field.name, std::nan(""), field.linear, std::nan(""), std::nan(""), field.note};
    derivative::Random random(999 + asked_);
    const Vector w = random.vector(f(x).size());
    const Vector gradient = pullback(x, w).at(index);
    const bool one_sided = !field.direction.empty();
    Vector d = field.direction;
    if (!one_sided) {
        const double n = std::sqrt(static_cast<double>(field.value.size()));
        d = along(random.vector(field.value.size()), 0.5 * n / norm(gradient), gradient);
        double mean = 0.0;
        for (const double v : d) mean += v / static_cast<double>(d.size());
        for (double& v : d) v = field.scale * (v - (field.simplex ? mean : 0.0));
    }
    Line line([&](double e) {
        Inputs moved = x;
        moved[index] = along(x[index], e, d);
        return f(moved);
    });
    const derivative::Samples samples = ladder(line, d, one_sided);
    const double slope = dot(gradient, d), difference = dot(w, derivative::tangent(samples, w));
    if (!(std::fabs(slope) > 0.0)) return row;
    row.differences = std::fabs(slope - difference) / std::fabs(difference);

    const Vector jd = field.product ? field.product(x, d) : derivative::tangent(samples, {});
    row.dot_product = 0.0;
    for (int k = 0; k < 2; ++k) {
        const Vector other = random.vector(w.size()), bar = pullback(x, other).at(index);
        row.dot_product = worse(std::fabs(dot(bar, d) - dot(other, jd)) / (norm(bar) * norm(d)), row.dot_product);
    }

    const double noise = rounding(line, w, slope, one_sided);
    if (field.linear) {
        if (remainder(line, w, 1.0, slope) <= 1e3 * noise + 1e-12 * std::fabs(slope)) row.slope = 0.0;
        return row;
    }
    double before = remainder(line, w, 1.0, slope);
    for (int k = 1; k <= kLevels; ++k) {
        const double now = remainder(line, w, std::ldexp(1.0, -k), slope);
        if (!(now > 100.0 * noise)) break;
        row.slope = std::log2(before / now);
        before = now;
    }
    return row;
}

void Table::add(const std::string& stage, const std::string& parameter, const std::function<Row()>& measure) {
    ++asked_;
    if (!names_only_ && !measures(stage)) return;
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    Row row{stage, parameter, none, false, none, none};
    if (measures(stage)) try {
            row = measure();
            row.stage = stage, row.parameter = parameter;
        } catch (const std::exception& e) {
            row.note = e.what();
        }
    rows_.push_back(row);
}

void Table::prove(const std::string& stage, const std::vector<Field>& fields, const Map& f, const Pullback& pullback) {
    Inputs x;
    for (const Field& field : fields) x.push_back(field.value);
    for (std::size_t k = 0; k < fields.size(); ++k)
        add(stage, fields[k].name, [&] { return measure(fields[k], k, x, f, pullback); });
}

}  // namespace table
