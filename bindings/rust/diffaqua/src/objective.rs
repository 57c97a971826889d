// SPDX-License-Identifier: MIT
//! Terms of a loss.
use crate::{Objective, handle, options::IntoRaw, sys};

/// One term of a loss; a loss is the weighted sum of several.
#[derive(Clone, Debug)]
pub struct ObjectiveTerm {
    raw: sys::dqa_objective_term,
    path: Vec<f64>,
}

// SAFETY: the pointer inside `raw` is NULL; `raw_terms` fills it in for the time of a call.
unsafe impl Send for ObjectiveTerm {}
// SAFETY: as above.
unsafe impl Sync for ObjectiveTerm {}

impl ObjectiveTerm {
    /// A term of weight 1.
    pub fn new(kind: Objective) -> Self {
        // SAFETY: the struct is plain numbers and pointers, and the library writes size_of bytes of it.
        let raw = unsafe { handle::filled(|out, size| sys::dqa_objective_term_init(out, size)) };
        let mut raw: sys::dqa_objective_term =
            raw.expect("the library fills a struct of the size that the header gives");
        raw.kind = kind.into_raw();
        ObjectiveTerm { raw, path: Vec::new() }
    }

    /// Default 1.
    #[must_use]
    pub fn weight(mut self, weight: f64) -> Self {
        self.raw.weight = weight;
        self
    }

    /// m: of [`Objective::PositionKeeping`] (two coordinates in two dimensions); default the origin.
    #[must_use]
    pub fn target(mut self, target: [f64; 3]) -> Self {
        self.raw.target = target;
        self
    }

    /// Weight of the heading in [`Objective::PositionKeeping`]; default 0.01.
    #[must_use]
    pub fn gamma(mut self, gamma: f64) -> Self {
        self.raw.gamma = gamma;
        self
    }

    /// > 0: rounds |x|; m, for [`Objective::Efficiency`] W/m^2; default 1e-4.
    #[must_use]
    pub fn epsilon(mut self, epsilon: f64) -> Self {
        self.raw.epsilon = epsilon;
        self
    }

    /// Of [`Objective::Path`]: rows of (time in s, coordinates in m) `[n_points][1 + dims]`, times increasing.
    #[must_use]
    pub fn path(mut self, rows: &[f64]) -> Self {
        self.path = rows.to_vec();
        self.raw.n_path = handle::count(rows);
        self
    }
}

/// The C array of a loss's terms, valid while `terms` live.
pub(crate) fn raw_terms(terms: &[ObjectiveTerm]) -> Vec<sys::dqa_objective_term> {
    let raw = |term: &ObjectiveTerm| sys::dqa_objective_term { path: handle::start(&term.path), ..term.raw };
    terms.iter().map(raw).collect()
}
