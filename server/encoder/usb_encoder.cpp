// SPDX-License-Identifier: Apache-2.0
//
// One class holds what all have in common: look, open, speak, look again. A talk is one device from
// its opening until it is gone; it ends with the problem that ended it, or with none at a stop.
#include "server/encoder/usb_encoder.h"

#include <utility>

#include "server/encoder/cooke_talk.h"
#include "server/encoder/hid_talk.h"
#include "server/encoder/qsb_talk.h"
#include "server/encoder/usb_port.h"

namespace flare {
namespace {

constexpr double kLookAgain_ms = 50.0;
constexpr int kFtdiVendor = 0x0403, kFtdiProduct = 0x6001;
constexpr char kQsbManufacturer[] = "US Digital";

UsbWanted WantedBy(const EncoderConfig& config) {
    UsbWanted wanted;
    wanted.vendor = config.vendor.value_or(kFtdiVendor);
    wanted.product = config.product.value_or(kFtdiProduct);
    wanted.serial = config.serial;
    if (config.kind == EncoderKind::kQsb) wanted.manufacturer = kQsbManufacturer;
    return wanted;
}

template <class Port, class Talk>
class UsbEncoder final : public EncoderSource {
  public:
    explicit UsbEncoder(EncoderTrack& track)
        : track_(track), thread_([this](const StopSignal& stop) { Run(stop); }) {}

  private:
    void Run(const StopSignal& stop) {
        const UsbWanted wanted = WantedBy(track_.config());
        Port port;  // libusb starts a thread of its own here, which stays ordinary
        GoBeforeRequests();
        while (!stop.set()) {
            UsbFound found = FindUsbDevice(port.context(), wanted);
            std::optional<UsbProblem> problem = std::move(found.problem);
            if (found.device) problem = Talk(port, track_, stop).Run(found);
            port.Close();
            if (problem) track_.Disconnected(problem->fault, problem->text);
            stop.WaitFor_ms(kLookAgain_ms);
        }
    }

    EncoderTrack& track_;
    SourceThread thread_;
};

}  // namespace

Result<std::unique_ptr<EncoderSource>> StartUsb(EncoderTrack& track) {
    switch (track.config().kind) {
        case EncoderKind::kQsb:
            return std::unique_ptr<EncoderSource>(new UsbEncoder<FtdiPort, QsbTalk>(track));
        case EncoderKind::kCooke:
            return std::unique_ptr<EncoderSource>(new UsbEncoder<FtdiPort, CookeTalk>(track));
        case EncoderKind::kHid:
            return std::unique_ptr<EncoderSource>(new UsbEncoder<HidPort, HidTalk>(track));
        default:
            return Error{"bad_config", "is no USB encoder", "kind"};
    }
}

}  // namespace flare
