// SPDX-License-Identifier: MIT
//! Stateless helpers for optimisers.
use crate::{
    Result,
    error::{check, require_length},
    handle::{count, index, start},
    sys,
};

/// One step of Adam (Kingma & Ba 2015), all arrays `[n]`; x and the moments are updated in place; iterations count from
/// 1.
pub fn adam_step(
    x: &mut [f64],
    gradient: &[f64],
    rates: &[f64],
    first_moment: &mut [f64],
    second_moment: &mut [f64],
    iteration: usize,
) -> Result<()> {
    let n = x.len();
    require_length("gradient", gradient.len(), n, "[n] as x")?;
    require_length("rates", rates.len(), n, "[n] as x")?;
    require_length("first_moment", first_moment.len(), n, "[n] as x")?;
    require_length("second_moment", second_moment.len(), n, "[n] as x")?;
    let (first, second) = (first_moment.as_mut_ptr(), second_moment.as_mut_ptr());
    // SAFETY: all arrays have n elements.
    check(unsafe {
        sys::dqa_adam_step(x.as_mut_ptr(), start(gradient), start(rates), first, second, count(x), index(iteration))
    })
}

/// Euclidean projection of x `[n]` onto the simplex (>= 0, sum 1), in place.
pub fn project_simplex(x: &mut [f64]) -> Result<()> {
    // SAFETY: the array has as many elements as it says.
    check(unsafe { sys::dqa_project_simplex(x.as_mut_ptr(), count(x)) })
}
