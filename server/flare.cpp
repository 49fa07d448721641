// SPDX-License-Identifier: Apache-2.0
#include "server/cli/app.h"

int main(int argc, char** argv) {
    return flare::cli::Run(argc, argv);
}
