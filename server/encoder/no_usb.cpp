// SPDX-License-Identifier: Apache-2.0
#include "server/encoder/usb_encoder.h"

namespace flare {

Result<std::unique_ptr<EncoderSource>> StartUsb(EncoderTrack& track) {
    return Error{"bad_config",
                 "'" + std::string(Name(track.config().kind)) +
                     "' is a USB device, and this program was built without libusb and libftdi "
                     "(FLARE_USB=OFF); build it with -DFLARE_USB=ON",
                 "kind"};
}

}  // namespace flare
