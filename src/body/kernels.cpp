// SPDX-License-Identifier: MIT
#include "body/kernels.hpp"

#include <cmath>

namespace dqa {

const BodyKernels& body_kernels(InstructionSet set) {
    return DQA_CHOOSE_TABLE(set, body_kernels);
}

void rotation_any(const double f[9], double r[9]) {
    const double xx = f[0], xy = f[1], xz = f[2], yx = f[3], yy = f[4], yz = f[5], zx = f[6], zy = f[7], zz = f[8];
    // Horn's matrix for tr(R^T F): rows and columns are quaternion components (w, x, y, z).
    double a[4][4] = {{xx + yy + zz, zy - yz, xz - zx, yx - xy},
                      {zy - yz, xx - yy - zz, xy + yx, zx + xz},
                      {xz - zx, xy + yx, yy - xx - zz, yz + zy},
                      {yx - xy, zx + xz, yz + zy, zz - xx - yy}};
    double v[4][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
    for (int sweep = 0; sweep < 30; ++sweep) {
        double off = 0.0, scale = 0.0;
        for (int p = 0; p < 4; ++p) {
            scale += a[p][p] * a[p][p];
            for (int q = p + 1; q < 4; ++q) off += a[p][q] * a[p][q];
        }
        if (off <= 1e-34 * (scale + off)) break;
        for (int p = 0; p < 4; ++p) {
            for (int q = p + 1; q < 4; ++q) {
                if (a[p][q] == 0.0) continue;
                const double tau = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
                const double t = (tau >= 0 ? 1.0 : -1.0) / (std::fabs(tau) + std::sqrt(1.0 + tau * tau));
                const double c = 1.0 / std::sqrt(1.0 + t * t), s = t * c;
                for (int k = 0; k < 4; ++k) {
                    const double akp = a[k][p], akq = a[k][q];
                    a[k][p] = c * akp - s * akq;
                    a[k][q] = s * akp + c * akq;
                }
                for (int k = 0; k < 4; ++k) {
                    const double apk = a[p][k], aqk = a[q][k];
                    a[p][k] = c * apk - s * aqk;
                    a[q][k] = s * apk + c * aqk;
                    const double vkp = v[k][p], vkq = v[k][q];
                    v[k][p] = c * vkp - s * vkq;
                    v[k][q] = s * vkp + c * vkq;
                }
            }
        }
    }
    int best = 0;
    for (int k = 1; k < 4; ++k)
        if (a[k][k] > a[best][best]) best = k;
    double w = v[0][best], x = v[1][best], y = v[2][best], z = v[3][best];
    const double norm = std::sqrt(w * w + x * x + y * y + z * z);
    w /= norm, x /= norm, y /= norm, z /= norm;
    r[0] = 1 - 2 * (y * y + z * z), r[1] = 2 * (x * y - w * z), r[2] = 2 * (x * z + w * y);
    r[3] = 2 * (x * y + w * z), r[4] = 1 - 2 * (x * x + z * z), r[5] = 2 * (y * z - w * x);
    r[6] = 2 * (x * z - w * y), r[7] = 2 * (y * z + w * x), r[8] = 1 - 2 * (x * x + y * y);
}

}  // namespace dqa
