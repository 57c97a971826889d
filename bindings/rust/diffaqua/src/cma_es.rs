// SPDX-License-Identifier: MIT
//! Search without gradients.
use std::{fmt, path::Path, ptr};

use crate::{
    CmaEsInfo, CmaEsOptions, Result,
    error::{check, require_length},
    handle::{Handle, c_path, count, start},
    sys,
};

/// CMA-ES: minimises a function of n numbers from its values alone. Ask for the candidates of a generation, tell their
/// values, and so on. The same options, seed and values give the same candidates to the bit. Unknowns are free: the
/// header says how bounds are kept.
pub struct CmaEs(Handle<sys::dqa_cma_es>);

// SAFETY: distinct objects may be used concurrently, and one by one thread at a time.
unsafe impl Send for CmaEs {}

impl CmaEs {
    /// A search that starts at mean `[n]`; scales `[n]`, each > 0: what counts as one unit of each unknown (None: 1).
    pub fn new(options: &CmaEsOptions, mean: &[f64], scales: Option<&[f64]>) -> Result<Self> {
        if let Some(scales) = scales {
            require_length("scales", scales.len(), mean.len(), "[n] as mean")?;
        }
        let units = scales.map_or(ptr::null(), start);
        // SAFETY: both arrays have n elements and are copied.
        Handle::create(sys::dqa_cma_es_free, |out| unsafe {
            sys::dqa_cma_es_create(&options.raw(), start(mean), units, count(mean), out)
        })
        .map(CmaEs)
    }

    /// Candidates `[population][n]` of this generation; asking again before telling gives the same ones.
    /// [`Status::Diverged`](crate::Status::Diverged) when the step size has grown until they overflow.
    pub fn ask(&mut self) -> Result<Vec<f64>> {
        let info = self.info()?;
        let mut candidates = vec![0.0; info.population * info.n];
        // SAFETY: the array has as many elements as it says.
        check(unsafe { sys::dqa_cma_es_ask(self.0.get(), candidates.as_mut_ptr(), count(&candidates)) })?;
        Ok(candidates)
    }

    /// Values `[population]` of the candidates in their order, +infinity for what could not be evaluated. Ends the
    /// generation.
    pub fn tell(&mut self, values: &[f64]) -> Result<()> {
        // SAFETY: the array has as many elements as it says.
        check(unsafe { sys::dqa_cma_es_tell(self.0.get(), start(values), count(values)) })
    }

    /// (candidate `[n]` of the lowest value so far, that value).
    pub fn best(&self) -> Result<(Vec<f64>, f64)> {
        let (mut x, mut value) = (vec![0.0; self.info()?.n], 0.0);
        // SAFETY: the array has as many elements as it says.
        check(unsafe { sys::dqa_cma_es_best(self.0.get(), x.as_mut_ptr(), count(&x), &mut value) })?;
        Ok((x, value))
    }

    /// Centre `[n]` of the distribution: often better than any candidate.
    pub fn mean(&self) -> Result<Vec<f64>> {
        let mut mean = vec![0.0; self.info()?.n];
        // SAFETY: the array has as many elements as it says.
        check(unsafe { sys::dqa_cma_es_mean(self.0.get(), mean.as_mut_ptr(), count(&mean)) })?;
        Ok(mean)
    }

    /// Sizes, generation, and how wide the search still is.
    pub fn info(&self) -> Result<CmaEsInfo> {
        // SAFETY: the handle lives; the library writes `size` bytes.
        CmaEsInfo::ask(|out, size| unsafe { sys::dqa_cma_es_get_info(self.0.get(), out, size) })
    }

    /// Writes the state to a file, whole or not at all; it goes on with the same bits.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<()> {
        let path = c_path(path.as_ref())?;
        // SAFETY: a C string that lives for the call.
        check(unsafe { sys::dqa_cma_es_save(self.0.get(), path.as_ptr()) })
    }

    /// The search of a file that [`save`](Self::save) wrote; [`Status::File`](crate::Status::File) for any other.
    pub fn load(path: impl AsRef<Path>) -> Result<Self> {
        let path = c_path(path.as_ref())?;
        // SAFETY: a C string that lives for the call.
        let load = |out: *mut *mut sys::dqa_cma_es| unsafe { sys::dqa_cma_es_load(path.as_ptr(), out) };
        Handle::create(sys::dqa_cma_es_free, load).map(CmaEs)
    }
}

impl fmt::Debug for CmaEs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("CmaEs").field(&self.info()).finish()
    }
}
