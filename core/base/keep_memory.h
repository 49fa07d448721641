// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace flare {

// Memory that is freed stays with the process for the next frame instead of going back to the
// system: fresh pages cost a frame more than what is put into them. For programs that render many
// frames; before other threads start. Up to 256 MiB of free memory stay; planes of more than 32 MiB
// go back at once. Does nothing where the C library is not GNU's.
void KeepFreedMemory();

}  // namespace flare
