// SPDX-License-Identifier: Apache-2.0
//
// Devices that umockdev plays (tests/support/usb_simulator.cpp), plugged in and pulled out while
// others read. What a picture makes of them is tests/scenario/usb_encoder_scenario.py.
#include "server/encoder/usb_encoder.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include "server/encoder/encoder_set.h"
#include "server/encoder/usb_device.h"

namespace flare {
namespace {

// The simulator as a child that obeys a line at a time.
class Bus {
  public:
    Bus() {
        std::array<int, 2> in{}, out{};
        EXPECT_EQ(pipe(in.data()), 0);
        EXPECT_EQ(pipe(out.data()), 0);
        child_ = fork();
        if (child_ == 0) {
            dup2(in[0], STDIN_FILENO);
            dup2(out[1], STDOUT_FILENO);
            for (const int fd : {in[0], in[1], out[0], out[1]}) close(fd);
            execl(USB_SIMULATOR, USB_SIMULATOR, nullptr);
            _exit(127);
        }
        close(in[0]);
        close(out[1]);
        to_ = fdopen(in[1], "w");
        from_ = fdopen(out[0], "r");
        const std::string line = Line();
        EXPECT_EQ(line.substr(0, 13), "UMOCKDEV_DIR=");
        setenv("UMOCKDEV_DIR", line.substr(13).c_str(), 1);
    }
    ~Bus() {
        fclose(to_);
        fclose(from_);
        waitpid(child_, nullptr, 0);
    }
    Bus(const Bus&) = delete;
    Bus& operator=(const Bus&) = delete;

    void Do(const std::string& command) {
        std::fprintf(to_, "%s\n", command.c_str());
        std::fflush(to_);
        EXPECT_EQ(Line(), "ok") << command;
    }

  private:
    std::string Line() {
        std::array<char, 512> text{};
        if (!std::fgets(text.data(), static_cast<int>(text.size()), from_)) return "";
        std::string line = text.data();
        while (!line.empty() && line.back() == '\n') line.pop_back();
        return line;
    }

    pid_t child_ = -1;
    FILE* to_ = nullptr;
    FILE* from_ = nullptr;
};

template <class Condition>
bool Eventually(const Condition& condition) {
    for (int i = 0; i < 20'000; ++i) {
        if (condition()) return true;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
}

EncoderConfig Box() {
    EncoderConfig config;
    config.name = "box";
    config.kind = EncoderKind::kHid;
    config.vendor = 0x16c0;
    config.product = 0x27d9;
    config.hid.fields[0] = HidField{1, 16, false, false};
    return config;
}

std::uint64_t Faults(const EncoderTrack& track, EncoderFault fault) {
    return track.Status(0.0).faults[static_cast<std::size_t>(fault)];
}

TEST(UsbEncoder, SurvivesAHundredPullsOfTheCable) {
    Bus bus;
    const auto set = EncoderSet::Start({Box()}, [](bool, const std::string&) {});
    ASSERT_TRUE(set) << set.error().message;
    const EncoderTrack& track = *(*set)->Find("box");
    std::atomic<bool> done = false;
    std::atomic<int> wrong = 0;
    std::vector<std::thread> readers;
    for (int i = 0; i < 2; ++i) {
        readers.emplace_back([&] {
            while (!done) {
                const EncoderStatus status = track.Status(EncoderClock::Now_s());
                if (status.newest && !status.newest->raw[0]) ++wrong;
                std::this_thread::sleep_for(std::chrono::microseconds(200));
            }
        });
    }
    for (int i = 1; i <= 100; ++i) {
        bus.Do("add h hid 7");
        bus.Do("set h " + std::to_string(i) + " 0");
        ASSERT_TRUE(Eventually([&] {
            const auto newest = track.Newest();
            return newest && newest->raw[0] == i;
        })) << i;
        bus.Do("remove h");
        ASSERT_TRUE(Eventually([&] { return !track.connected(); })) << i;
        EXPECT_EQ(track.Newest()->raw[0], i) << "the last state is held";
    }
    done = true;
    for (std::thread& reader : readers) reader.join();
    EXPECT_EQ(wrong, 0);
    EXPECT_EQ(Faults(track, EncoderFault::kUnplugged), 100u);
}

// A program that runs as root is never denied anything, so the code is given by hand.
TEST(UsbEncoder, WantOfPermissionNamesTheRule) {
    const UsbProblem problem = UsbProblemFrom(LIBUSB_ERROR_ACCESS, "opening the device");
    EXPECT_EQ(problem.fault, EncoderFault::kDenied);
    EXPECT_NE(problem.text.find("deploy/udev/60-flared-encoders.rules"), std::string::npos);
    EXPECT_EQ(UsbProblemFrom(LIBUSB_ERROR_NO_DEVICE, "reading").fault, EncoderFault::kUnplugged);
    EXPECT_EQ(UsbProblemFrom(LIBUSB_ERROR_PIPE, "reading").fault, EncoderFault::kStall);
}

}  // namespace
}  // namespace flare
