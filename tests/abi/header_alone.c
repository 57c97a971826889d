/* SPDX-License-Identifier: MIT
 * The public header by itself, twice: it needs nothing before it, and may be included again. Compiled as every
 * standard of C and C++ that callers use. */
#include "diffaqua.h"

int main(void);
int main(void) {
    return dqa_abi_version() == DQA_ABI_VERSION ? 0 : 1;
}
