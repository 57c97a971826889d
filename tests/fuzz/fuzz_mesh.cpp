// SPDX-License-Identifier: MIT
// Fuzzing of the readers of mesh files: the first byte chooses the format, the rest is the file. Whatever the bytes are
// there is a mesh or an Error, within time and memory that grow with their number.
#include <cstdint>
#include <string_view>

#include "grid/error.hpp"
#include "shape/mesh_readers.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    const std::string_view content(reinterpret_cast<const char*>(data + 1), size - 1);
    const dqa::MeshSource source{content, "fuzzed"};
    try {
        const dqa::TriangleMesh mesh = data[0] % 3 == 0   ? dqa::read_stl(source)
                                       : data[0] % 3 == 1 ? dqa::read_obj(source)
                                                          : dqa::read_ply(source);
        dqa::clean_and_check(mesh, "fuzzed", nullptr);
    } catch (const dqa::Error&) {
    }
    return 0;
}
