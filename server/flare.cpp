// SPDX-License-Identifier: Apache-2.0
#include "core/base/keep_memory.h"
#include "server/cli/app.h"

int main(int argc, char** argv) {
    flare::KeepFreedMemory();
    return flare::cli::Run(argc, argv);
}
