// SPDX-License-Identifier: Apache-2.0
#include "server/encoder/usb_encoder.h"

namespace flare {

Result<std::unique_ptr<EncoderSource>> StartUsb(EncoderTrack&) {
    return Error{"bad_config", "this program was built without USB (FLARE_USB=OFF)", "kind"};
}

}  // namespace flare
