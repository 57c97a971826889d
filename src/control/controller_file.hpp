// SPDX-License-Identifier: MIT
// Controllers as files: kind, settings and parameters, read back with the same bits.
#pragma once

#include <memory>
#include <string>

#include "control/controller.hpp"

namespace dqa {

// Throws ERROR_UNSUPPORTED for a controller of the caller's own functions, ERROR_IO otherwise.
void save_controller(const Controller& controller, const std::string& path);
// Throws ERROR_IO, or ERROR_FILE for a file that save_controller did not write like this.
std::unique_ptr<Controller> load_controller(const std::string& path);

}  // namespace dqa
