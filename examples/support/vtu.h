/* SPDX-License-Identifier: MIT
 * A motion as VTK files, for ParaView and whatever else reads them. */
#ifndef DQA_EXAMPLES_VTU_H
#define DQA_EXAMPLES_VTU_H

#include "motion.h"

#define VTU_FOLDER "frames"
#define VTU_INDEX "swimmer.pvd"

/* Writes folder/frames/swimmer_NNNN.vtu for every frame and folder/swimmer.pvd, the index with their times; removes
 * frames of an older, longer run. Point data: displacement from rest (m) and velocity (m/s).
 * DONE, FAILED (said) or INTERRUPTED. */
int vtu_write_motion(const motion* m, const char* folder);

#endif
