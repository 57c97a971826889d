// SPDX-License-Identifier: MIT
// Fuzzing of the texts that the example programs read: lists of bases, tables of a path or current, schedules,
// checkpoints (with the right checksum). Each is understood or refused with a message.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "bytes.hpp"

extern "C" {
#include "support/bases.h"
#include "support/checkpoint.h"
#include "support/hash.h"
#include "support/say.h"
#include "support/schedule.h"
#include "support/table.h"
}

namespace {

int add_nothing(void*, const char*) {
    return 0;
}

// A checkpoint of three unknowns; the text goes between its settings and its seal.
void load_checkpoint(const std::string& text) {
    static const std::string folder = [] {
        const std::string name =
            (std::filesystem::temp_directory_path() / ("fuzz-text-" + std::to_string(getpid()))).string();
        std::filesystem::create_directory(name);
        return name;
    }();
    std::string content = "codesign checkpoint 6\nsettings\n" CHECKPOINT_SETTINGS_END + text;
    char seal[64];
    std::snprintf(seal, sizeof seal, "checksum %016llx\n",
                  static_cast<unsigned long long>(hash_bytes(content.data(), content.size())));
    content += seal;
    std::ofstream(folder + "/" CHECKPOINT_FILE, std::ios::binary) << content;
    static const double theta[2] = {0.5, 0.1};
    static const options_form form{};
    options o{};
    run r;
    o.form = &form;
    o.plan.n_stages = 2;
    o.mlp = 1;
    o.weights[0] = 1.0;
    if (run_create(&r, &o, 1, theta, 2, 1.0) != DONE) std::abort();
    if (checkpoint_load(&r, "settings\n", folder.c_str()) == DONE &&
        (r.iteration < 0 || r.stage < 0 || r.stage > 1 || r.best_iteration > r.iteration))
        std::abort();
    run_free(&r);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::Bytes in(data, size);
    const int kind = in.below(4);
    const std::string text = in.rest();
    if (kind == 0) {
        const fuzz::MemoryFile file(text);
        bases list{};
        (void)bases_read(&list, file.path(), add_nothing, nullptr);
        bases_free(&list);
    } else if (kind == 1) {
        const fuzz::MemoryFile file(text);
        double* rows = nullptr;
        std::int64_t n = 0;
        (void)table_read(file.path(), "m", &rows, &n);
        std::free(rows);
    } else if (kind == 2) {
        schedule s;
        (void)schedule_parse(&s, text.c_str());
    } else {
        load_checkpoint(text);
    }
    return 0;
}
