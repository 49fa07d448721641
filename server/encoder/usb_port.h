// SPDX-License-Identifier: Apache-2.0
//
// Bytes to and from an open device: a serial line behind an FTDI chip, or the reports of a HID
// device. Reads wait for 100 ms at most. One thread.
#pragma once

#include <ftdi.h>
#include <libusb.h>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/encoder/usb_device.h"

namespace flare {

// What a read brought: bytes (none: silence), or why not.
struct UsbRead {
    std::vector<std::uint8_t> bytes;
    std::optional<UsbProblem> problem;

    std::string_view text() const {
        const void* const data = bytes.data();
        return {static_cast<const char*>(data), bytes.size()};
    }
};

class FtdiPort {
  public:
    FtdiPort();
    ~FtdiPort();
    FtdiPort(const FtdiPort&) = delete;
    FtdiPort& operator=(const FtdiPort&) = delete;

    libusb_context* context() const { return ftdi_->usb_ctx; }
    // 8 data bits, no parity, one stop bit, latency timer 1 ms. A kernel driver is detached.
    std::optional<UsbProblem> Open(libusb_device* device, int baud);
    void Close();
    std::optional<UsbProblem> SetBaud(int baud);
    std::optional<UsbProblem> Write(std::string_view text);
    UsbRead Read();

  private:
    ftdi_context* ftdi_;
    bool open_ = false;
};

class HidPort {
  public:
    HidPort();
    ~HidPort();
    HidPort(const HidPort&) = delete;
    HidPort& operator=(const HidPort&) = delete;

    libusb_context* context() const { return context_; }
    std::optional<UsbProblem> Open(libusb_device* device);
    void Close();
    UsbRead Read();
    // Makes a halted endpoint work again.
    void ClearStall();

  private:
    libusb_context* context_ = nullptr;
    libusb_device_handle* handle_ = nullptr;
    int interface_ = 0;
    std::uint8_t endpoint_ = 0;
    std::uint16_t report_bytes_ = 0;
};

}  // namespace flare
