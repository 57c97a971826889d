/* SPDX-License-Identifier: MIT
 * An optimisation by CMA-ES, from the losses alone: what gradients are measured against. */
#ifndef DQA_EXAMPLES_EVOLUTION_H
#define DQA_EXAMPLES_EVOLUTION_H

#include "descent.h"

/* The search that belongs to the run, in its folder: a new one before the first generation, otherwise the one that its
 * last checkpoint left. DONE or FAILED (said). */
int evolution_open(const descent* d, dqa_cma_es** search);
/* One generation: its best candidate is one row of the run. DONE, FAILED (said) or INTERRUPTED, and then the generation
 * is to be made again from its beginning. */
int evolution_generation(const descent* d, dqa_cma_es* search);
/* 1 when candidates differ by less than 1e-6 of the unit of each unknown. */
int evolution_converged(const dqa_cma_es* search);

#endif
