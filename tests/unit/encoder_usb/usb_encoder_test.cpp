// SPDX-License-Identifier: Apache-2.0
//
// Devices that umockdev plays (tests/support/usb_simulator.cpp), plugged in and pulled out while
// others read. What a picture makes of them is tests/scenario/usb_encoder_scenario.py.
#include "server/encoder/usb_encoder.h"

#include <gtest/gtest.h>
#include <linux/capability.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <mutex>
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

TEST(UsbEncoder, ATwinIsRefusedUntilASerialNumberTellsThem) {
    Bus bus;
    bus.Do("add a hid 1");
    bus.Do("add b hid 2");
    bus.Do("set b 22 0");
    std::vector<EncoderConfig> configs{Box(), Box()};
    configs[1].name = "second";
    configs[1].serial = "2";
    const auto set = EncoderSet::Start(configs, [](bool, const std::string&) {});
    ASSERT_TRUE(set);
    const EncoderTrack& any = *(*set)->Find("box");
    const EncoderTrack& second = *(*set)->Find("second");
    ASSERT_TRUE(Eventually([&] { return Faults(any, EncoderFault::kAmbiguous) > 0; }));
    EXPECT_EQ(any.Status(EncoderClock::Now_s()).health, EncoderHealth::kFailed);
    ASSERT_TRUE(Eventually([&] { return second.samples() > 0; }));
    EXPECT_EQ(second.Newest()->raw[0], 22.0);
}

EncoderConfig Ring(const std::string& name, const std::string& serial, LensAxis axis) {
    EncoderConfig config;
    config.name = name;
    config.kind = EncoderKind::kQsb;
    config.serial = serial;
    config.axis = axis;
    return config;
}

bool Awaits(const EncoderTrack& track, LensAxis axis, double count) {
    return Eventually([&] {
        const auto newest = track.Newest();
        return newest && newest->raw[Index(axis)] == count;
    });
}

TEST(UsbEncoder, SeveralQsbsAreToldByTheirSerialNumbers) {
    Bus bus;
    const std::vector<EncoderConfig> configs{Ring("focus", "11", LensAxis::kFocus),
                                             Ring("iris", "12", LensAxis::kIris),
                                             Ring("zoom", "13", LensAxis::kZoom)};
    const auto set = EncoderSet::Start(configs, [](bool, const std::string&) {});
    ASSERT_TRUE(set);
    for (const int serial : {13, 11, 12}) {
        const std::string name = "q" + std::to_string(serial);
        bus.Do("add " + name + " qsb " + std::to_string(serial));
        bus.Do("set " + name + " " + std::to_string(100 * serial) + " 0");
    }
    for (std::size_t i = 0; i < configs.size(); ++i) {
        const EncoderTrack& track = *(*set)->Find(configs[i].name);
        EXPECT_TRUE(Awaits(track, kLensAxes[i], 100.0 * static_cast<double>(11 + i)));
        EXPECT_EQ(Faults(track, EncoderFault::kAmbiguous), 0u);
    }
}

TEST(UsbEncoder, AQsbTakesItsCountFromTheIndexMark) {
    Bus bus;
    std::vector<EncoderConfig> configs{Ring("with", "1", LensAxis::kFocus),
                                       Ring("without", "2", LensAxis::kFocus)};
    configs[0].index_count = -500;
    const auto set = EncoderSet::Start(configs, [](bool, const std::string&) {});
    ASSERT_TRUE(set);
    const EncoderTrack& with = *(*set)->Find("with");
    const EncoderTrack& without = *(*set)->Find("without");
    for (const char* name : {"1", "2"}) {
        bus.Do(std::string("add ") + name + " qsb " + name);
        bus.Do(std::string("set ") + name + " 70 0");
    }
    EXPECT_TRUE(Awaits(with, LensAxis::kFocus, 70));
    EXPECT_TRUE(Awaits(without, LensAxis::kFocus, 70));
    for (const char* name : {"1", "2"}) {
        bus.Do(std::string("index ") + name);
        bus.Do(std::string("set ") + name + " 100 0");
    }
    EXPECT_TRUE(Awaits(with, LensAxis::kFocus, -470));
    EXPECT_TRUE(Awaits(without, LensAxis::kFocus, 100));
}

// Capabilities taken from this thread and from those that it starts meanwhile.
class Without {
  public:
    explicit Without(std::uint32_t capabilities) {
        EXPECT_EQ(syscall(SYS_capget, &header_, old_.data()), 0);
        std::array<__user_cap_data_struct, 2> less = old_;
        less[0].effective &= ~capabilities;
        EXPECT_EQ(syscall(SYS_capset, &header_, less.data()), 0);
    }
    ~Without() { EXPECT_EQ(syscall(SYS_capset, &header_, old_.data()), 0); }
    Without(const Without&) = delete;
    Without& operator=(const Without&) = delete;

  private:
    __user_cap_header_struct header_{_LINUX_CAPABILITY_VERSION_3, 0};
    std::array<__user_cap_data_struct, 2> old_{};
};

TEST(UsbEncoder, IsDeniedUntilTheRuleIsThereAndSaysSoOnce) {
    Bus bus;
    bus.Do("add h hid 7");
    bus.Do("deny h");
    std::mutex mutex;
    std::vector<std::string> lines;
    const auto told = [&](const char* what) {
        const std::lock_guard lock(mutex);
        return std::count_if(lines.begin(), lines.end(), [&](const std::string& line) {
            return line.find(what) != std::string::npos;
        });
    };
    Result<std::unique_ptr<EncoderSet>> set = Error{"", "", ""};
    {
        // With these root opens every file.
        const Without as_any_user((1U << CAP_DAC_OVERRIDE) | (1U << CAP_DAC_READ_SEARCH));
        set = EncoderSet::Start({Box()}, [&](bool, const std::string& line) {
            const std::lock_guard lock(mutex);
            lines.push_back(line);
        });
    }
    ASSERT_TRUE(set);
    const EncoderTrack& track = *(*set)->Find("box");
    const auto denied = [&] { return Faults(track, EncoderFault::kDenied); };
    ASSERT_TRUE(Eventually([&] { return denied() >= 3; }));
    const EncoderStatus status = track.Status(EncoderClock::Now_s());
    EXPECT_EQ(status.health, EncoderHealth::kFailed);
    EXPECT_NE(status.problem.find("deploy/udev/60-flared-encoders.rules"), std::string::npos);
    EXPECT_EQ(told("no permission"), 1) << "once a change";
    bus.Do("allow h");
    ASSERT_TRUE(Eventually([&] { return track.connected(); }));
    EXPECT_EQ(track.Status(EncoderClock::Now_s()).problem, "");
    EXPECT_EQ(told("connected to"), 1);
}

TEST(UsbEncoder, SaysOnceThatPriorityIsRefused) {
    const auto lines_of = [](const std::vector<EncoderConfig>& configs) {
        int lines = 0;
        const auto set = EncoderSet::Start(configs, [&](bool warning, const std::string& line) {
            if (line.find("real-time priority") == std::string::npos) return;
            EXPECT_TRUE(warning);
            ++lines;
        });
        EXPECT_TRUE(set);
        return lines;
    };
    Bus bus;
    EncoderConfig other = Box();
    other.name = "other";
    EncoderConfig udp;
    udp.kind = EncoderKind::kFreeD;
    EXPECT_EQ(lines_of({Box(), other}), MayGoBeforeRequests() ? 0 : 1);
    rlimit old{};
    ASSERT_EQ(getrlimit(RLIMIT_RTPRIO, &old), 0);
    const rlimit none{0, old.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_RTPRIO, &none), 0);
    {
        const Without priority(1U << CAP_SYS_NICE);
        EXPECT_FALSE(MayGoBeforeRequests());
        EXPECT_EQ(lines_of({Box(), other}), 1);
        EXPECT_EQ(lines_of({udp}), 0) << "it has no thread that goes before others";
    }
    ASSERT_EQ(setrlimit(RLIMIT_RTPRIO, &old), 0);
}

TEST(UsbEncoder, ErrorsOfLibusbAreNamed) {
    const UsbProblem problem = UsbProblemFrom(LIBUSB_ERROR_ACCESS, "opening the device");
    EXPECT_EQ(problem.fault, EncoderFault::kDenied);
    EXPECT_NE(problem.text.find("deploy/udev/60-flared-encoders.rules"), std::string::npos);
    EXPECT_EQ(UsbProblemFrom(LIBUSB_ERROR_NO_DEVICE, "reading").fault, EncoderFault::kUnplugged);
    EXPECT_EQ(UsbProblemFrom(LIBUSB_ERROR_PIPE, "reading").fault, EncoderFault::kStall);
}

}  // namespace
}  // namespace flare
