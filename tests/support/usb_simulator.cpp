// SPDX-License-Identifier: Apache-2.0
//
// USB encoders that are not there, below libusb: umockdev answers the ioctls of usbdevfs and this
// program plays the devices. Run under umockdev-wrapper; it prints "UMOCKDEV_DIR=..." for the
// environment of the program under test (which needs LD_PRELOAD of umockdev's library too), then
// obeys commands on standard input, one a line, each answered with "ok" or "no":
//
//   add NAME KIND SERIAL     plug one in; KIND is qsb, cooke or hid
//   remove NAME              pull it out, whatever transfer is under way
//   set NAME A B             qsb: count A; hid: 16-bit counts A and B; cooke: focus A mm, T B/100
//   clock NAME               qsb: the count is the monotonic clock in us, modulo 2^30
//   period NAME US           time between two records
//   fault NAME WHAT          none, silence, noise, stall, short
//
// `sent NAME` answers with the number of records that the device has sent.
#include <gio/gio.h>
#include <linux/usbdevice_fs.h>
#include <sys/ioctl.h>
#include <umockdev.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <deque>
#include <iostream>
#include <map>
#include <memory>
#include <mutex>
#include <sstream>
#include <string>
#include <vector>

namespace {

enum class Kind { kQsb, kCooke, kHid };
enum class Trouble { kNone, kSilence, kNoise, kStall, kShort };

// A transfer that the program has submitted.
struct Transfer {
    UMockdevIoctlData* urb;
    UMockdevIoctlData* buffer;  // null: without data

    usbdevfs_urb& fields() const {
        void* const data = urb->data;
        return *static_cast<usbdevfs_urb*>(data);
    }
};

struct Device {
    Kind kind = Kind::kQsb;
    std::string serial, node, path;
    UMockdevIoctlBase* handler = nullptr;

    std::mutex mutex;  // guards what follows: ioctls come on a thread of umockdev
    bool gone = false, streaming = false, checksums = false, clock = false;
    Trouble trouble = Trouble::kNone;
    long a = 0, b = 0;
    gint64 period_us = 3'500, next_us = 0, said_us = 0;
    unsigned long sent = 0;
    std::deque<Transfer> pending, ended;
    std::string to_device, to_host;
};

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

// With the two letters of checksum mode and the end of the line.
std::string CookeLine(const Device& device, std::string text) {
    if (device.checksums) {
        unsigned sum = 0xff;
        for (const char c : text) sum ^= static_cast<unsigned char>(c);
        text += static_cast<char>(0x40 | sum >> 4);
        text += static_cast<char>(0x40 | (sum & 15));
    }
    return text + "\n\r";
}

std::string Record(const Device& device) {
    if (device.kind == Kind::kQsb) {
        const auto now = static_cast<unsigned long>(g_get_monotonic_time()) & 0x3fffffffUL;
        const auto count = device.clock ? now : static_cast<unsigned long>(device.a);
        return "s0E" + Hex(count, 8) + Hex(device.sent, 8) + "!\n";
    }
    return CookeLine(device, "d" + Packed(static_cast<unsigned long>(device.a), 4) +
                                 Packed(static_cast<unsigned long>(device.b), 2) + "\x82\x88" +
                                 Packed(0, 2) + Packed(87'250, 4) + Packed(400, 4) +
                                 Packed(404, 4) + Packed(68, 2) + Packed(39, 2) + Packed(0, 2) +
                                 "S5/100-009");
}

void ObeyQsb(Device& device, const std::string& line) {
    if (line == "R14")
        device.to_host +=
            "r1400060003"
            "00000000!\n";
    if (line == "S0E") device.streaming = true;
    if (line.starts_with("W")) device.to_host += "w" + line.substr(1, 2) + "0000000000000000!\n";
}

void ObeyCooke(Device& device, const std::string& line) {
    if (line == "H") device.streaming = false;
    if (line == "N") {
        device.checksums = false;
        device.to_host +=
            CookeLine(device, "NS5/100-009OCooke Optics Electronic Lenses!LPF100N100UMt92  B5.03");
    }
    if (line == "Kb7") device.to_host += CookeLine(device, "!");
    if (line == "G") {
        device.checksums = true;
        device.to_host += CookeLine(device, "!");
    }
    if (line == "Kc") device.streaming = true;
}

void Written(Device& device, const std::string& bytes) {
    for (const char c : bytes) {
        if (c != '\n' && c != '\r') {
            device.to_device += c;
            continue;
        }
        if (device.kind == Kind::kQsb) ObeyQsb(device, device.to_device);
        if (device.kind == Kind::kCooke) ObeyCooke(device, device.to_device);
        device.to_device.clear();
    }
}

// What standard requests want: string descriptors, UTF-16.
int Control(const Device& device, guint8* setup, int length) {
    if (setup[0] != 0x80 || setup[1] != 6 || setup[3] != 3) return 0;
    const bool ftdi = device.kind != Kind::kHid;
    const std::string texts[] = {"", device.kind == Kind::kQsb ? "US Digital" : "Maker",
                                 ftdi ? "USB <-> QSB" : "Ring encoder", device.serial};
    guint8* const out = setup + 8;
    std::vector<guint8> bytes{4, 3, 9, 4};  // English
    if (setup[2] > 0 && setup[2] < 4) {
        bytes = {static_cast<guint8>(2 + 2 * texts[setup[2]].size()), 3};
        for (const char c : texts[setup[2]]) {
            bytes.push_back(static_cast<guint8>(c));
            bytes.push_back(0);
        }
    }
    const int size = std::min(static_cast<int>(bytes.size()), length - 8);
    std::memcpy(out, bytes.data(), static_cast<std::size_t>(size));
    return size;
}

// The next bytes of the device, or -1: nothing yet.
int Input(Device& device, guint8* out, int length) {
    const gint64 now_us = g_get_monotonic_time();
    if (device.next_us == 0) device.next_us = now_us;
    const bool due = now_us >= device.next_us && device.trouble != Trouble::kSilence;
    if (device.kind == Kind::kHid) {
        if (!due) return -1;
        device.next_us += device.period_us;
        ++device.sent;
        const auto low = [](long value) { return static_cast<guint8>(value & 255); };
        const guint8 report[] = {
            1, low(device.a), low(device.a >> 8), low(device.b), low(device.b >> 8), 0, 0, 0};
        const int size = device.trouble == Trouble::kShort ? 2 : 8;
        std::memcpy(out, report, static_cast<std::size_t>(size));
        return size;
    }
    if (device.streaming && due) {
        // As many as are due: a device does not wait for its reader.
        while (device.next_us <= now_us && device.to_host.size() < 4'096) {
            device.next_us += device.period_us;
            ++device.sent;
            device.to_host += device.trouble == Trouble::kNoise ? "\x01garbage!\n" : Record(device);
        }
    }
    out[0] = 0x01;
    out[1] = 0x60;
    const int size = std::min({static_cast<int>(device.to_host.size()), 62, length - 2});
    std::memcpy(out + 2, device.to_host.data(), static_cast<std::size_t>(size));
    device.to_host.erase(0, static_cast<std::size_t>(size));
    // The chip's latency timer: at least its two status bytes every millisecond.
    if (size == 0 && now_us - device.said_us < 1'000) return -1;
    device.said_us = now_us;
    return 2 + size;
}

// True if the transfer is done.
bool Serve(Device& device, const Transfer& transfer) {
    usbdevfs_urb& urb = transfer.fields();
    guint8* const data = transfer.buffer ? transfer.buffer->data : nullptr;
    urb.status = 0;
    if (urb.type == USBDEVFS_URB_TYPE_CONTROL) {
        urb.actual_length = Control(device, data, urb.buffer_length);
        return true;
    }
    if ((urb.endpoint & 0x80) == 0) {
        urb.actual_length = urb.buffer_length;
        const void* const bytes = data;
        Written(device, std::string(static_cast<const char*>(bytes),
                                    static_cast<std::size_t>(urb.buffer_length)));
        return true;
    }
    if (device.trouble == Trouble::kStall) {
        urb.status = -EPIPE;
        urb.actual_length = 0;
        return true;
    }
    urb.actual_length = Input(device, data, urb.buffer_length);
    return urb.actual_length >= 0;
}

void Reap(Device& device, UMockdevIoctlClient* client, UMockdevIoctlData* argument) {
    const auto finish = [&](const Transfer& transfer) {
        UMockdevIoctlData* const target =
            umockdev_ioctl_data_resolve(argument, 0, sizeof(gpointer), nullptr);
        umockdev_ioctl_data_set_ptr(target, 0, transfer.urb);
        umockdev_ioctl_client_complete(client, 0, 0);
        umockdev_ioctl_data_unref(target);
    };
    if (!device.ended.empty()) {
        const Transfer transfer = device.ended.front();
        device.ended.pop_front();
        return finish(transfer);
    }
    if (device.gone) {
        if (device.pending.empty()) {
            umockdev_ioctl_client_complete(client, -1, ENODEV);
            return;
        }
        const Transfer transfer = device.pending.front();
        device.pending.pop_front();
        transfer.fields().status = -ESHUTDOWN;
        return finish(transfer);
    }
    for (auto at = device.pending.begin(); at != device.pending.end(); ++at) {
        if (!Serve(device, *at)) continue;
        const Transfer transfer = *at;
        device.pending.erase(at);
        return finish(transfer);
    }
    g_usleep(300);  // or libusb spins
    umockdev_ioctl_client_complete(client, -1, EAGAIN);
}

gboolean Ioctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, Device* device) {
    const std::lock_guard lock(device->mutex);
    UMockdevIoctlData* const argument = umockdev_ioctl_client_get_arg(client);
    const gulong request = umockdev_ioctl_client_get_request(client);
    const auto done = [&](int result, int error) {
        umockdev_ioctl_client_complete(client, result, error);
        return TRUE;
    };
    switch (request) {
        case USBDEVFS_GET_CAPABILITIES: {
            UMockdevIoctlData* const data = umockdev_ioctl_data_resolve(argument, 0, 4, nullptr);
            const guint32 all = USBDEVFS_CAP_BULK_SCATTER_GATHER | USBDEVFS_CAP_BULK_CONTINUATION |
                                USBDEVFS_CAP_NO_PACKET_SIZE_LIM |
                                USBDEVFS_CAP_REAP_AFTER_DISCONNECT | USBDEVFS_CAP_ZERO_PACKET;
            std::memcpy(data->data, &all, sizeof all);
            done(0, 0);
            umockdev_ioctl_data_unref(data);
            return TRUE;
        }
        case USBDEVFS_CLEAR_HALT:
            if (device->trouble == Trouble::kStall) device->trouble = Trouble::kNone;
            return done(0, 0);
        case USBDEVFS_CLAIMINTERFACE:
        case USBDEVFS_RELEASEINTERFACE:
        case USBDEVFS_RESET:
        case USBDEVFS_RESETEP:
        case USBDEVFS_SETINTERFACE:
        case USBDEVFS_SETCONFIGURATION:
        case USBDEVFS_DISCONNECT_CLAIM:
            return done(0, 0);
        case USBDEVFS_GETDRIVER:
        case USBDEVFS_IOCTL:
            return done(-1, ENODATA);
        case USBDEVFS_SUBMITURB: {
            if (device->gone) return done(-1, ENODEV);
            Transfer transfer{
                umockdev_ioctl_data_resolve(argument, 0, sizeof(usbdevfs_urb), nullptr), nullptr};
            const usbdevfs_urb& urb = transfer.fields();
            if (urb.buffer_length > 0) {
                transfer.buffer =
                    umockdev_ioctl_data_resolve(transfer.urb, offsetof(usbdevfs_urb, buffer),
                                                static_cast<gsize>(urb.buffer_length), nullptr);
            }
            device->pending.push_back(transfer);
            return done(0, 0);
        }
        case USBDEVFS_DISCARDURB: {
            const void* const given = argument->data;
            gulong address = 0;
            std::memcpy(&address, given, sizeof address);
            for (auto at = device->pending.begin(); at != device->pending.end(); ++at) {
                if (at->urb->client_addr != address) continue;
                at->fields().status = -ENOENT;
                device->ended.push_back(*at);
                device->pending.erase(at);
                return done(0, 0);
            }
            return done(-1, EINVAL);
        }
        case USBDEVFS_REAPURB:
        case USBDEVFS_REAPURBNDELAY:
            Reap(*device, client, argument);
            return TRUE;
        default:
            return FALSE;
    }
}

// Device, configuration, interface and endpoints as sysfs has them, in hex.
std::string Descriptors(Kind kind) {
    if (kind == Kind::kHid) {
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

class Bus {
  public:
    Bus() : testbed_(umockdev_testbed_new()) {}

    bool Add(const std::string& name, Kind kind, const std::string& serial) {
        if (devices_.contains(name)) return false;
        const int number = 1 + ++added_ % 127;
        char node[40], path[60];
        std::snprintf(node, sizeof node, "bus/usb/001/%03d", number);
        std::snprintf(path, sizeof path, "/devices/usb1/1-%d", added_);
        auto device = std::make_unique<Device>();
        device->kind = kind;
        device->serial = serial;
        device->node = std::string("/dev/") + node;
        device->path = path;
        device->handler = umockdev_ioctl_base_new();
        g_object_connect(device->handler, "signal-after::handle-ioctl", Ioctl, device.get(),
                         nullptr);
        GError* error = nullptr;
        if (!umockdev_testbed_attach_ioctl(testbed_, device->node.c_str(), device->handler,
                                           &error)) {
            return Failed(error);
        }
        std::ostringstream text;
        text << "P: " << path << "\nN: " << node
             << "\nE: SUBSYSTEM=usb\nE: BUSNUM=001\nE: DEVNUM=" << node + 12 << "\nE: DEVNAME=/dev/"
             << node
             << "\nE: DEVTYPE=usb_device\nA: bConfigurationValue=1\\n\nA: busnum=1\\n\nA: devnum="
             << number
             << "\\n\nA: speed=12\\n\nA: idVendor=" << (kind == Kind::kHid ? "16c0" : "0403")
             << "\\n\nA: idProduct=" << (kind == Kind::kHid ? "27d9" : "6001")
             << "\\n\nH: descriptors=" << Descriptors(kind) << "\n";
        if (!umockdev_testbed_add_from_string(testbed_, text.str().c_str(), &error)) {
            return Failed(error);
        }
        devices_[name] = std::move(device);
        return true;
    }

    bool Remove(const std::string& name) {
        Device* const device = Find(name);
        if (!device) return false;
        {
            const std::lock_guard lock(device->mutex);
            device->gone = true;
        }
        const std::string path = "/sys" + device->path;
        umockdev_testbed_uevent(testbed_, path.c_str(), "remove");
        umockdev_testbed_remove_device(testbed_, path.c_str());
        // Programs may still hold it open: it is kept, as the kernel keeps it.
        removed_.push_back(std::move(devices_[name]));
        devices_.erase(name);
        return true;
    }

    Device* Find(const std::string& name) {
        const auto found = devices_.find(name);
        return found == devices_.end() ? nullptr : found->second.get();
    }

  private:
    static bool Failed(GError* error) {
        std::fprintf(stderr, "usb_simulator: %s\n", error->message);
        g_error_free(error);
        return false;
    }

    UMockdevTestbed* testbed_;
    int added_ = 0;
    std::map<std::string, std::unique_ptr<Device>> devices_;
    std::vector<std::unique_ptr<Device>> removed_;
};

bool Obey(Bus& bus, std::istringstream& words) {
    static const std::map<std::string, Kind> kKinds{
        {"qsb", Kind::kQsb}, {"cooke", Kind::kCooke}, {"hid", Kind::kHid}};
    static const std::map<std::string, Trouble> kTroubles{{"none", Trouble::kNone},
                                                          {"silence", Trouble::kSilence},
                                                          {"noise", Trouble::kNoise},
                                                          {"stall", Trouble::kStall},
                                                          {"short", Trouble::kShort}};
    std::string verb, name, word, serial;
    words >> verb >> name;
    if (verb == "add") {
        words >> word >> serial;
        return kKinds.contains(word) && bus.Add(name, kKinds.at(word), serial);
    }
    if (verb == "remove") return bus.Remove(name);
    Device* const device = bus.Find(name);
    if (!device) return false;
    const std::lock_guard lock(device->mutex);
    if (verb == "set") return static_cast<bool>(words >> device->a >> device->b);
    if (verb == "clock") return device->clock = true;
    if (verb == "period") return static_cast<bool>(words >> device->period_us);
    if (verb == "fault") {
        words >> word;
        if (!kTroubles.contains(word)) return false;
        device->trouble = kTroubles.at(word);
        device->next_us = g_get_monotonic_time();
        return true;
    }
    if (verb == "sent") {
        std::cout << device->sent << ' ';
        return true;
    }
    return false;
}

}  // namespace

int main() {
    Bus bus;
    std::cout << "UMOCKDEV_DIR=" << g_getenv("UMOCKDEV_DIR") << std::endl;
    std::string line;
    while (std::getline(std::cin, line)) {
        std::istringstream words(line);
        std::cout << (Obey(bus, words) ? "ok" : "no") << std::endl;
    }
    return 0;
}
