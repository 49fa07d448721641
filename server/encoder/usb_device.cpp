// SPDX-License-Identifier: Apache-2.0
#include "server/encoder/usb_device.h"

#include <array>
#include <vector>

namespace flare {
namespace {

struct Strings {
    std::string manufacturer, product, serial;
};

std::string ReadString(libusb_device_handle* handle, std::uint8_t index) {
    if (index == 0) return "";
    std::array<unsigned char, 256> text{};
    const int size = libusb_get_string_descriptor_ascii(handle, index, text.data(),
                                                        static_cast<int>(text.size()));
    return size > 0 ? std::string(text.begin(), text.begin() + size) : "";
}

// 0, or an error code of libusb.
int ReadStrings(libusb_device* device, const libusb_device_descriptor& descriptor,
                Strings& strings) {
    libusb_device_handle* handle = nullptr;
    if (const int code = libusb_open(device, &handle); code != 0) return code;
    strings.manufacturer = ReadString(handle, descriptor.iManufacturer);
    strings.product = ReadString(handle, descriptor.iProduct);
    strings.serial = ReadString(handle, descriptor.iSerialNumber);
    libusb_close(handle);
    return 0;
}

std::string Description(const Strings& strings) {
    std::string text = strings.manufacturer;
    if (!strings.product.empty()) text += (text.empty() ? "" : " ") + strings.product;
    if (text.empty()) text = "USB device";
    if (!strings.serial.empty()) text += ", serial number " + strings.serial;
    return text;
}

}  // namespace

UsbProblem UsbProblemFrom(int code, const std::string& what) {
    switch (code) {
        case LIBUSB_ERROR_ACCESS:
            return {EncoderFault::kDenied,
                    what +
                        ": no permission; install deploy/udev/60-flared-encoders.rules and plug "
                        "the device in again"};
        case LIBUSB_ERROR_NO_DEVICE:
        case LIBUSB_ERROR_NOT_FOUND:
            return {EncoderFault::kUnplugged, "unplugged"};
        case LIBUSB_ERROR_PIPE:
            return {EncoderFault::kStall, what + ": the endpoint stalled"};
        case LIBUSB_ERROR_TIMEOUT:
            return {EncoderFault::kTimeout, what + ": no answer"};
        default:
            return {EncoderFault::kOther, what + ": " + libusb_error_name(code)};
    }
}

UsbFound FindUsbDevice(libusb_context* context, const UsbWanted& wanted) {
    UsbFound found;
    libusb_device** list = nullptr;
    const ssize_t count = libusb_get_device_list(context, &list);
    if (count < 0) {
        found.problem = UsbProblemFrom(static_cast<int>(count), "the list of USB devices");
        return found;
    }
    int fitting = 0;
    for (ssize_t i = 0; i < count; ++i) {
        libusb_device_descriptor descriptor{};
        if (libusb_get_device_descriptor(list[i], &descriptor) != 0) continue;
        if (descriptor.idVendor != wanted.vendor || descriptor.idProduct != wanted.product)
            continue;
        Strings strings;
        const int code = ReadStrings(list[i], descriptor, strings);
        // One that goes away while it is looked at is none.
        if (code == LIBUSB_ERROR_NO_DEVICE || code == LIBUSB_ERROR_NOT_FOUND) continue;
        if (code != 0) {
            if (!found.problem) found.problem = UsbProblemFrom(code, "opening the device");
            continue;
        }
        if (!wanted.serial.empty() && strings.serial != wanted.serial) continue;
        if (!wanted.manufacturer.empty() && strings.manufacturer != wanted.manufacturer) continue;
        if (++fitting == 1) {
            found.device.reset(libusb_ref_device(list[i]));
            found.description = Description(strings);
        }
    }
    libusb_free_device_list(list, 1);
    if (fitting == 1) found.problem.reset();
    if (fitting > 1) {
        found.device.reset();
        found.problem = UsbProblem{EncoderFault::kAmbiguous,
                                   std::to_string(fitting) +
                                       " devices fit; write the serial number of one into the "
                                       "configuration"};
    }
    return found;
}

}  // namespace flare
