// SPDX-License-Identifier: Apache-2.0
//
// Finding one device on the bus with libusb.
#pragma once

#include <libusb.h>

#include <memory>
#include <optional>
#include <string>

#include "server/encoder/encoder_track.h"

namespace flare {

// Why a device cannot be used, or not any more.
struct UsbProblem {
    EncoderFault fault = EncoderFault::kOther;
    std::string text;
};

// From an error code of libusb.
UsbProblem UsbProblemFrom(int code, const std::string& what);

struct UsbDeviceUnref {
    void operator()(libusb_device* device) const { libusb_unref_device(device); }
};

struct UsbFound {
    std::unique_ptr<libusb_device, UsbDeviceUnref> device;  // null: there is none
    std::string description;                                // maker, product, serial number
    std::optional<UsbProblem> problem;                      // there is one, and it cannot be used
};

struct UsbWanted {
    int vendor = 0, product = 0;
    std::string serial, manufacturer;  // "": any
};

UsbFound FindUsbDevice(libusb_context* context, const UsbWanted& wanted);

}  // namespace flare
