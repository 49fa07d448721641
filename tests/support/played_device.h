// SPDX-License-Identifier: Apache-2.0
//
// One USB encoder as a program sees it through its endpoints: what it answers to standard requests
// and to what is written to it, and what it has to say at a moment. A QSB and a Cooke /i lens
// behind an FTDI chip, or a HID device of two 16-bit counts. Knows no bus. `mutex` is for its
// users: the bus asks on a thread of its own while a script turns the rings.
#pragma once

#include <cstdint>
#include <mutex>
#include <string>

namespace flare::test {

enum class DeviceKind { kQsb, kCooke, kHid };
enum class Trouble { kNone, kSilence, kNoise, kStall, kShort };

class PlayedDevice {
  public:
    PlayedDevice(DeviceKind kind, std::string serial) : kind_(kind), serial_(std::move(serial)) {}

    // Device, configuration, interface and endpoints as sysfs has them, in hex.
    static const char* Descriptors(DeviceKind kind);

    // The answer to a standard request is put behind its eight bytes; its size.
    int Control(std::uint8_t* setup, int length) const;
    void Written(const std::string& bytes);
    // The next bytes at a time, or -1: nothing yet.
    int Input(std::int64_t now_us, std::uint8_t* out, int length);
    // The ring passes the index mark.
    void PassIndex();

    std::mutex mutex;
    Trouble trouble = Trouble::kNone;
    long a = 0, b = 0;    // qsb: count a; hid: both counts; cooke: focus in mm, T in hundredths
    bool clock = false;   // qsb: the count is the time in us, modulo 2^30, at which it was due
    bool number = false;  // qsb: the count is the number of the record
    std::int64_t period_us = 3'500, next_us = 0;  // of records; when the next is due
    unsigned long sent = 0;

  private:
    std::string Record(std::int64_t due_us) const;
    std::string CookeLine(std::string text) const;
    void ObeyQsb(const std::string& line);
    void ObeyCooke(const std::string& line);
    int HidReport(std::uint8_t* out);

    const DeviceKind kind_;
    const std::string serial_;
    bool streaming_ = false, checksums_ = false;
    unsigned long mode_ = 3, preset_ = 0;  // qsb: registers 03 and 08
    long index_offset_ = 0;
    std::int64_t said_us_ = 0;
    std::string to_device_, to_host_;
};

}  // namespace flare::test
