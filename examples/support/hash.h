/* SPDX-License-Identifier: MIT
 * A checksum that finds damage and tells contents apart: 64-bit FNV-1a. */
#ifndef DQA_EXAMPLES_HASH_H
#define DQA_EXAMPLES_HASH_H

#include <stddef.h>
#include <stdint.h>

uint64_t hash_bytes(const void* data, size_t size);

#endif
