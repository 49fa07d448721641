// SPDX-License-Identifier: Apache-2.0
#include "tests/support/played_device.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

namespace flare::test {
namespace {

std::string Hex(unsigned long value, int digits) {
    char text[20];
    std::snprintf(text, sizeof text, "%0*lX", digits, value & 0xffffffffUL);
    return text;
}

std::string Packed(unsigned long value, int characters) {
    std::string text;
    for (int i = characters - 1; i >= 0; --i) {
        text += static_cast<char>(0x40 | (value >> (6 * i) & 0x3f));
    }
    return text;
}

}  // namespace

const char* PlayedDevice::Descriptors(DeviceKind kind) {
    if (kind == DeviceKind::kHid) {
        return "1201000200000040"
               "c016d9270001"
               "01020301"
               "0902220001010080"
               "32"
               "090400000103000000"
               "092111010001220800"
               "07058103080008";
    }
    return "1201000200000008"
           "030401600006"
           "01020301"
           "0902200001010080"
           "2d"
           "0904000002ffffff02"
           "07058102400000"
           "07050202400000";
}

// String descriptors, UTF-16.
int PlayedDevice::Control(std::uint8_t* setup, int length) const {
    if (setup[0] != 0x80 || setup[1] != 6 || setup[3] != 3) return 0;
    const bool ftdi = kind_ != DeviceKind::kHid;
    const std::string texts[] = {"", kind_ == DeviceKind::kQsb ? "US Digital" : "Maker",
                                 ftdi ? "USB <-> QSB" : "Ring encoder", serial_};
    std::vector<std::uint8_t> bytes{4, 3, 9, 4};  // English
    if (setup[2] > 0 && setup[2] < 4) {
        bytes = {static_cast<std::uint8_t>(2 + 2 * texts[setup[2]].size()), 3};
        for (const char c : texts[setup[2]]) {
            bytes.push_back(static_cast<std::uint8_t>(c));
            bytes.push_back(0);
        }
    }
    const int size = std::min(static_cast<int>(bytes.size()), length - 8);
    std::memcpy(setup + 8, bytes.data(), static_cast<std::size_t>(size));
    return size;
}

void PlayedDevice::Written(const std::string& bytes) {
    for (const char c : bytes) {
        if (c != '\n' && c != '\r') {
            to_device_ += c;
            continue;
        }
        if (kind_ == DeviceKind::kQsb) ObeyQsb(to_device_);
        if (kind_ == DeviceKind::kCooke) ObeyCooke(to_device_);
        to_device_.clear();
    }
}

void PlayedDevice::ObeyQsb(const std::string& line) {
    if (line == "R14") {
        to_host_ +=
            "r1400060003"
            "00000000!\n";
    }
    if (line == "S0E") streaming_ = true;
    if (line.size() < 4 || line[0] != 'W') return;
    const unsigned long value = std::strtoul(line.c_str() + 3, nullptr, 16);
    if (line.starts_with("W03")) mode_ = value;
    if (line.starts_with("W08")) preset_ = value;
    to_host_ += "w" + line.substr(1, 2) + Hex(value, 8) + "00000000!\n";
}

// Bits 4 and 5 of LS7366R's MDR0: 01 loads the counter from the preset.
void PlayedDevice::PassIndex() {
    if ((mode_ & 0x30) == 0x10) index_offset_ = static_cast<long>(preset_) - a;
}

void PlayedDevice::ObeyCooke(const std::string& line) {
    if (line == "H") streaming_ = false;
    if (line == "N") {
        checksums_ = false;
        to_host_ += CookeLine("NS5/100-009OCooke Optics Electronic Lenses!LPF100N100UMt92  B5.03");
    }
    if (line == "Kb7") to_host_ += CookeLine("!");
    if (line == "G") {
        checksums_ = true;
        to_host_ += CookeLine("!");
    }
    if (line == "Kc") streaming_ = true;
}

// With the two letters of checksum mode and the end of the line.
std::string PlayedDevice::CookeLine(std::string text) const {
    if (checksums_) {
        unsigned sum = 0xff;
        for (const char c : text) sum ^= static_cast<unsigned char>(c);
        text += static_cast<char>(0x40 | sum >> 4);
        text += static_cast<char>(0x40 | (sum & 15));
    }
    return text + "\n\r";
}

std::string PlayedDevice::Record(std::int64_t due_us) const {
    if (kind_ == DeviceKind::kQsb) {
        auto count = static_cast<unsigned long>(a + index_offset_);
        if (clock) count = static_cast<unsigned long>(due_us) & 0x3fffffffUL;
        if (number) count = sent;
        return "s0E" + Hex(count, 8) + Hex(sent, 8) + "!\n";
    }
    const auto focus = number ? sent : static_cast<unsigned long>(a);
    return CookeLine("d" + Packed(focus, 4) + Packed(static_cast<unsigned long>(b), 2) +
                     "\x82\x88" + Packed(0, 2) + Packed(87'250, 4) + Packed(400, 4) +
                     Packed(404, 4) + Packed(68, 2) + Packed(39, 2) + Packed(0, 2) + "S5/100-009");
}

int PlayedDevice::HidReport(std::uint8_t* out) {
    next_us += period_us;
    ++sent;
    const auto low = [](long value) { return static_cast<std::uint8_t>(value & 255); };
    const std::uint8_t report[] = {1, low(a), low(a >> 8), low(b), low(b >> 8), 0, 0, 0};
    const int size = trouble == Trouble::kShort ? 2 : 8;
    std::memcpy(out, report, static_cast<std::size_t>(size));
    return size;
}

int PlayedDevice::Input(std::int64_t now_us, std::uint8_t* out, int length) {
    if (next_us == 0) next_us = now_us;
    const bool due = now_us >= next_us && trouble != Trouble::kSilence;
    if (kind_ == DeviceKind::kHid) return due ? HidReport(out) : -1;
    if (streaming_ && due) {
        // As many as are due: a device does not wait for its reader.
        while (next_us <= now_us && to_host_.size() < 4'096) {
            to_host_ += trouble == Trouble::kNoise ? "\x01garbage!\n" : Record(next_us);
            next_us += period_us;
            ++sent;
        }
    }
    out[0] = 0x01;
    out[1] = 0x60;
    const int size = std::min({static_cast<int>(to_host_.size()), 62, length - 2});
    std::memcpy(out + 2, to_host_.data(), static_cast<std::size_t>(size));
    to_host_.erase(0, static_cast<std::size_t>(size));
    // The chip's latency timer: at least its two status bytes every millisecond.
    if (size == 0 && now_us - said_us_ < 1'000) return -1;
    said_us_ = now_us;
    return 2 + size;
}

}  // namespace flare::test
