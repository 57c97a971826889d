// SPDX-License-Identifier: MIT
// Source of the body kernels, included once per instruction set (kernels_baseline.cpp, _avx2.cpp, _avx512.cpp) with
// DQA_KERNEL_TABLE naming the table it defines. See kernels.hpp for the layouts and formulas.
#include "body/corotated_kernels.hpp"
#include "body/muscle_kernels.hpp"
#include "body/neo_hookean_kernels.hpp"
#include "body/reduced_kernels.hpp"

namespace dqa {

const BodyKernels& DQA_KERNEL_TABLE() {
    const ElasticKernels volume{
        kVolumePoint, 1, volume_gradient, {volume_product<double>, volume_product<float>}, volume_bar, volume_filter};
    const ElasticKernels jacobian{kJacobianPoint,    1,
                                  jacobian_gradient, {jacobian_product<double>, jacobian_product<float>},
                                  jacobian_bar,      jacobian_filter};
    static const BodyKernels table = {
        {{{8 * kCorotatedPoint,
           8,
           corotated_gradient,
           {corotated_product<double>, corotated_product<float>},
           corotated_bar,
           corotated_filter},
          volume,
          {8 * kNeoPoint, 8, neo_gradient, {neo_product<double>, neo_product<float>}, neo_bar, neo_filter},
          jacobian},
         {{kCorotatedPoint,
           1,
           reduced_corotated_gradient,
           {reduced_corotated_product<double>, reduced_corotated_product<float>},
           reduced_corotated_bar,
           reduced_corotated_filter},
          volume,
          {kNeoPoint,
           1,
           reduced_neo_gradient,
           {reduced_neo_product<double>, reduced_neo_product<float>},
           reduced_neo_bar,
           neo_filter},
          jacobian}},
        muscle_gradient,
        {muscle_product<double>, muscle_product<float>},
        muscle_bar};
    return table;
}

}  // namespace dqa
