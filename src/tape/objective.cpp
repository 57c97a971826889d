// SPDX-License-Identifier: MIT
#include "tape/objective.hpp"

namespace dqa {

double travel_loss(const Design& design, const double* q_first, const double* q_last) {
    double sum = 0.0, weight = 0.0;
    for (std::size_t n = 0; n < design.spine().size(); ++n) {
        sum += design.spine()[n] * (q_last[3 * n] - q_first[3 * n]);
        weight += design.spine()[n];
    }
    return -sum / weight;
}

void travel_pullback(const Design& design, const double* q_first, const double* q_last, double scale,
                     double* q_first_bar, double* q_last_bar, double* spine_bar) {
    const double loss = travel_loss(design, q_first, q_last);
    double weight = 0.0;
    for (const double w : design.spine()) weight += w;
    for (std::size_t n = 0; n < design.spine().size(); ++n) {
        const double w = scale * design.spine()[n] / weight;
        q_last_bar[3 * n] -= w;
        q_first_bar[3 * n] += w;
        spine_bar[n] -= scale * (q_last[3 * n] - q_first[3 * n] + loss) / weight;
    }
}

}  // namespace dqa
