// SPDX-License-Identifier: Apache-2.0
#include "server/encoder/usb_port.h"

#include <array>

namespace flare {
namespace {

constexpr int kWait_ms = 100;
constexpr int kWriteWait_ms = 500;

// libftdi gives libusb's codes from bulk transfers, and numbers of its own for the rest.
bool IsLibusbCode(int code) {
    return code == LIBUSB_ERROR_IO || code == LIBUSB_ERROR_NO_DEVICE || code == LIBUSB_ERROR_PIPE ||
           code == LIBUSB_ERROR_TIMEOUT || code == LIBUSB_ERROR_OVERFLOW;
}

UsbProblem FtdiProblem(int code, const std::string& what, ftdi_context* ftdi) {
    if (IsLibusbCode(code) && code != LIBUSB_ERROR_IO) return UsbProblemFrom(code, what);
    return {EncoderFault::kOther, what + ": " + ftdi_get_error_string(ftdi)};
}

}  // namespace

FtdiPort::FtdiPort() : ftdi_(ftdi_new()) {
    FLARE_CHECK(ftdi_ != nullptr);
    ftdi_->usb_read_timeout = kWait_ms;
    ftdi_->usb_write_timeout = kWriteWait_ms;
}

FtdiPort::~FtdiPort() {
    Close();
    ftdi_free(ftdi_);
}

std::optional<UsbProblem> FtdiPort::Open(libusb_device* device, int baud) {
    if (const int code = ftdi_usb_open_dev(ftdi_, device); code != 0) {
        // -4 is "unable to open", -5 "unable to claim": by far the most are for want of permission
        // or held by another program, and its text says which.
        return UsbProblem{EncoderFault::kOther,
                          std::string("opening the device: ") + ftdi_get_error_string(ftdi_)};
    }
    open_ = true;
    if (const auto problem = SetBaud(baud)) return problem;
    if (const int code = ftdi_set_line_property(ftdi_, BITS_8, STOP_BIT_1, NONE); code != 0) {
        return FtdiProblem(code, "setting 8N1", ftdi_);
    }
    if (const int code = ftdi_set_latency_timer(ftdi_, 1); code != 0) {
        return FtdiProblem(code, "setting the latency timer", ftdi_);
    }
    return std::nullopt;
}

void FtdiPort::Close() {
    if (open_) ftdi_usb_close(ftdi_);
    open_ = false;
}

std::optional<UsbProblem> FtdiPort::SetBaud(int baud) {
    const int code = ftdi_set_baudrate(ftdi_, baud);
    if (code == 0) return std::nullopt;
    return FtdiProblem(code, "setting " + std::to_string(baud) + " baud", ftdi_);
}

std::optional<UsbProblem> FtdiPort::Write(std::string_view text) {
    const std::vector<unsigned char> bytes(text.begin(), text.end());
    const int code = ftdi_write_data(ftdi_, bytes.data(), static_cast<int>(bytes.size()));
    if (code == static_cast<int>(bytes.size())) return std::nullopt;
    return FtdiProblem(code, "writing", ftdi_);
}

UsbRead FtdiPort::Read() {
    UsbRead read;
    read.bytes.resize(512);
    const int code = ftdi_read_data(ftdi_, read.bytes.data(), static_cast<int>(read.bytes.size()));
    read.bytes.resize(code > 0 ? static_cast<std::size_t>(code) : 0);
    if (code < 0 && code != LIBUSB_ERROR_TIMEOUT) {
        read.problem = FtdiProblem(code, "reading", ftdi_);
    }
    return read;
}

HidPort::HidPort() {
    FLARE_CHECK(libusb_init(&context_) == 0);
}

HidPort::~HidPort() {
    Close();
    libusb_exit(context_);
}

std::optional<UsbProblem> HidPort::Open(libusb_device* device) {
    libusb_config_descriptor* config = nullptr;
    if (const int code = libusb_get_active_config_descriptor(device, &config); code != 0) {
        return UsbProblemFrom(code, "reading the device's description");
    }
    endpoint_ = 0;
    for (int i = 0; i < config->bNumInterfaces && endpoint_ == 0; ++i) {
        if (config->interface[i].num_altsetting == 0) continue;
        const libusb_interface_descriptor& setting = config->interface[i].altsetting[0];
        if (setting.bInterfaceClass != LIBUSB_CLASS_HID) continue;
        for (int e = 0; e < setting.bNumEndpoints && endpoint_ == 0; ++e) {
            const libusb_endpoint_descriptor& endpoint = setting.endpoint[e];
            const bool in = (endpoint.bEndpointAddress & LIBUSB_ENDPOINT_IN) != 0;
            const int type = endpoint.bmAttributes & LIBUSB_TRANSFER_TYPE_MASK;
            if (!in || type != LIBUSB_TRANSFER_TYPE_INTERRUPT) continue;
            interface_ = setting.bInterfaceNumber;
            endpoint_ = endpoint.bEndpointAddress;
            report_bytes_ = endpoint.wMaxPacketSize;
        }
    }
    libusb_free_config_descriptor(config);
    if (endpoint_ == 0 || report_bytes_ == 0) {
        return UsbProblem{EncoderFault::kOther, "the device has no HID reports"};
    }
    if (const int code = libusb_open(device, &handle_); code != 0) {
        handle_ = nullptr;
        return UsbProblemFrom(code, "opening the device");
    }
    libusb_set_auto_detach_kernel_driver(handle_, 1);
    if (const int code = libusb_claim_interface(handle_, interface_); code != 0) {
        const UsbProblem problem = UsbProblemFrom(code, "claiming the device");
        libusb_close(handle_);
        handle_ = nullptr;
        return problem;
    }
    return std::nullopt;
}

void HidPort::Close() {
    if (!handle_) return;
    libusb_release_interface(handle_, interface_);
    libusb_close(handle_);
    handle_ = nullptr;
}

UsbRead HidPort::Read() {
    UsbRead read;
    read.bytes.resize(report_bytes_);
    int size = 0;
    const int code =
        libusb_interrupt_transfer(handle_, endpoint_, read.bytes.data(),
                                  static_cast<int>(read.bytes.size()), &size, kWait_ms);
    read.bytes.resize(code == 0 && size > 0 ? static_cast<std::size_t>(size) : 0);
    if (code != 0 && code != LIBUSB_ERROR_TIMEOUT) read.problem = UsbProblemFrom(code, "reading");
    return read;
}

void HidPort::ClearStall() {
    libusb_clear_halt(handle_, endpoint_);
}

}  // namespace flare
