// SPDX-License-Identifier: MIT
// The table of derivatives: one row for each input of each stage, measured without a look at what the pullback should
// give. For f at x, a direction d (random, with a part along the gradient) and random covectors w:
//   slope        of |<w, f(x + e d) - f(x)> - e <pullback(w), d>| over e, at the smallest steps above the rounding of
//   f; differences  |<pullback(w), d> - D| / |D|, D the five-point difference of <w, f> along d; dot product
//   |<pullback(w'), d> - <w', J d>| / (|pullback(w')| |d|) for two further covectors w', J d the five-point
//                difference of all of f or, where the stage has one, its own product with the Jacobian.
// Steps of differences: where two neighbours of the ladder agree best.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "derivative_checks.hpp"

namespace table {

using derivative::Vector;
using Inputs = std::vector<Vector>;
using Map = std::function<Vector(const Inputs& x)>;
using Pullback = std::function<Inputs(const Inputs& x, const Vector& bar)>;  // one cotangent for each input

struct Row {
    std::string stage, parameter;
    double slope = 0.0;   // of the Taylor remainder; a linear map has none
    bool linear = false;  // and that its remainder is rounding was checked
    double differences = 0.0, dot_product = 0.0;
    std::string note{};  // what the figures mean, or the error that came in their place
    bool passed() const;
};

// The larger error; no number is worse than any.
inline double worse(double a, double b) {
    return std::isnan(a) || a > b ? a : b;
}

// An input of a stage, and how it is varied.
struct Field {
    std::string name;
    Vector value;
    double scale = 1.0;  // of the entries of the longest difference
    bool linear = false;
    std::string note{};
    bool simplex = false;                                                  // directions sum to zero
    Vector direction{};                                                    // empty: random; else x + e d, e >= 0 only
    std::function<Vector(const Inputs& x, const Vector& d)> product = {};  // J d
};

class Table {
public:
    // only: part of the names of the stages that are wanted.
    Table(bool names_only, std::string only) : names_only_(names_only), only_(std::move(only)) {}
    bool measures(const std::string& stage) const { return !names_only_ && stage.find(only_) != std::string::npos; }
    const std::vector<Row>& rows() const { return rows_; }
    void prove(const std::string& stage, const std::vector<Field>& fields, const Map& f, const Pullback& pullback);
    // What was measured elsewhere; not called where only names are asked for.
    void add(const std::string& stage, const std::string& parameter, const std::function<Row()>& measure);

private:
    Row measure(const Field& field, std::size_t index, const Inputs& x, const Map& f, const Pullback& pullback) const;

    bool names_only_;
    std::string only_;
    std::uint64_t asked_ = 0;  // rows so far, unwanted ones included: seed of the next
    std::vector<Row> rows_;
};

// Rows of each subject, in the order of the chain.
void shape_rows(Table& table);
void muscle_rows(Table& table);
void body_rows(Table& table);
void reduced_body_rows(Table& table);
void water_rows(Table& table);
void step_rows(Table& table);
void sensor_rows(Table& table);
void controller_rows(Table& table);
void objective_rows(Table& table);
void chain_rows(Table& table);

}  // namespace table
