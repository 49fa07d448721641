// SPDX-License-Identifier: Apache-2.0
//
// USB encoders that are not there, below libusb: umockdev answers the ioctls of usbdevfs and this
// program plays the devices (played_device.h). Run under umockdev-wrapper; it prints
// "UMOCKDEV_DIR=..." for the environment of the program under test (which needs LD_PRELOAD of
// umockdev's library too), then obeys commands on standard input, one a line, each answered with
// "ok" or "no":
//
//   add NAME KIND SERIAL     plug one in; KIND is qsb, cooke or hid
//   remove NAME              pull it out, whatever transfer is under way
//   deny NAME, allow NAME    take the permission to open it, give it back
//   set NAME A B             qsb: count A; hid: 16-bit counts A and B; cooke: focus A mm, T B/100
//   clock NAME               qsb: the count is the monotonic clock in us, modulo 2^30
//   number NAME              qsb: the count is the record's number, from 0; cooke: the focus in mm
//   is index NAME               qsb: the ring passes the index mark period NAME US           time
//   between two records fault NAME WHAT          none, silence, noise, stall, short
//
// `sent NAME` answers with the number of records that the device has sent.
#include <gio/gio.h>
#include <linux/usbdevice_fs.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
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

#include "tests/support/played_device.h"

namespace {

using flare::test::DeviceKind;
using flare::test::PlayedDevice;
using flare::test::Trouble;

// A program that waits for a transfer asks again and again: its file is no device, and is always
// ready. This long it is made to wait, with everybody else, for one thread serves them all.
constexpr gulong kPollPause_us = 150;

// A transfer that a program has submitted through one of its open files.
struct Transfer {
    UMockdevIoctlClient* client;
    UMockdevIoctlData* urb;
    UMockdevIoctlData* buffer;  // null: without data

    usbdevfs_urb& fields() const {
        void* const data = urb->data;
        return *static_cast<usbdevfs_urb*>(data);
    }
};

// A device on the bus. What follows the played device is guarded by its mutex.
struct Device {
    Device(DeviceKind kind, const std::string& serial) : played(kind, serial) {}

    std::string node, path;
    UMockdevIoctlBase* handler = nullptr;
    PlayedDevice played;
    bool gone = false;
    std::deque<Transfer> pending, ended;
};

// True if the transfer is done.
bool Serve(Device& device, const Transfer& transfer) {
    usbdevfs_urb& urb = transfer.fields();
    guint8* const data = transfer.buffer ? transfer.buffer->data : nullptr;
    urb.status = 0;
    if (urb.type == USBDEVFS_URB_TYPE_CONTROL) {
        urb.actual_length = device.played.Control(data, urb.buffer_length);
        return true;
    }
    if ((urb.endpoint & 0x80) == 0) {
        urb.actual_length = urb.buffer_length;
        const void* const bytes = data;
        device.played.Written(std::string(static_cast<const char*>(bytes),
                                          static_cast<std::size_t>(urb.buffer_length)));
        return true;
    }
    if (device.played.trouble == Trouble::kStall) {
        urb.status = -EPIPE;
        urb.actual_length = 0;
        return true;
    }
    urb.actual_length = device.played.Input(g_get_monotonic_time(), data, urb.buffer_length);
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
    // Each open file gets its own transfers back.
    const auto own = [&](const Transfer& transfer) { return transfer.client == client; };
    if (const auto at = std::find_if(device.ended.begin(), device.ended.end(), own);
        at != device.ended.end()) {
        const Transfer transfer = *at;
        device.ended.erase(at);
        return finish(transfer);
    }
    if (device.gone) {
        const auto at = std::find_if(device.pending.begin(), device.pending.end(), own);
        if (at == device.pending.end()) {
            umockdev_ioctl_client_complete(client, -1, ENODEV);
            return;
        }
        const Transfer transfer = *at;
        device.pending.erase(at);
        transfer.fields().status = -ESHUTDOWN;
        return finish(transfer);
    }
    bool waits = false;
    for (auto at = device.pending.begin(); at != device.pending.end(); ++at) {
        if (!own(*at)) continue;
        waits = true;
        if (!Serve(device, *at)) continue;
        const Transfer transfer = *at;
        device.pending.erase(at);
        return finish(transfer);
    }
    if (waits) g_usleep(kPollPause_us);
    umockdev_ioctl_client_complete(client, -1, EAGAIN);
}

gboolean Ioctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, Device* device) {
    const std::lock_guard lock(device->played.mutex);
    UMockdevIoctlData* const argument = umockdev_ioctl_client_get_arg(client);
    const gulong request = umockdev_ioctl_client_get_request(client);
    const auto done = [&](int result, int error) {
        umockdev_ioctl_client_complete(client, result, error);
        return TRUE;
    };
    switch (request) {
        case USBDEVFS_GET_CAPABILITIES: {
            // The first that an open file asks for: what another of the same address left is void.
            std::erase_if(device->pending, [&](const Transfer& t) { return t.client == client; });
            std::erase_if(device->ended, [&](const Transfer& t) { return t.client == client; });
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
            if (device->played.trouble == Trouble::kStall) device->played.trouble = Trouble::kNone;
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
                client, umockdev_ioctl_data_resolve(argument, 0, sizeof(usbdevfs_urb), nullptr),
                nullptr};
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
                if (at->client != client || at->urb->client_addr != address) continue;
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

class Bus {
  public:
    Bus() : testbed_(umockdev_testbed_new()) {}

    bool Add(const std::string& name, DeviceKind kind, const std::string& serial) {
        if (devices_.contains(name)) return false;
        const int number = 1 + ++added_ % 127;
        char node[40], path[60];
        std::snprintf(node, sizeof node, "bus/usb/001/%03d", number);
        std::snprintf(path, sizeof path, "/devices/usb1/1-%d", added_);
        auto device = std::make_unique<Device>(kind, serial);
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
             << "\\n\nA: speed=12\\n\nA: idVendor=" << (kind == DeviceKind::kHid ? "16c0" : "0403")
             << "\\n\nA: idProduct=" << (kind == DeviceKind::kHid ? "27d9" : "6001")
             << "\\n\nH: descriptors=" << PlayedDevice::Descriptors(kind) << "\n";
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
            const std::lock_guard lock(device->played.mutex);
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

    // As the kernel's device nodes have it: by the mode of the file.
    bool Permit(const Device& device, bool allowed) {
        const std::string file = g_getenv("UMOCKDEV_DIR") + device.node;
        return chmod(file.c_str(), allowed ? 0666 : 0) == 0;
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
    static const std::map<std::string, DeviceKind> kKinds{
        {"qsb", DeviceKind::kQsb}, {"cooke", DeviceKind::kCooke}, {"hid", DeviceKind::kHid}};
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
    if (verb == "deny" || verb == "allow") return bus.Permit(*device, verb == "allow");
    PlayedDevice& played = device->played;
    const std::lock_guard lock(played.mutex);
    if (verb == "set") return static_cast<bool>(words >> played.a >> played.b);
    if (verb == "clock") return played.clock = true;
    if (verb == "number") return played.number = true;
    if (verb == "period") return static_cast<bool>(words >> played.period_us);
    if (verb == "index") {
        played.PassIndex();
        return true;
    }
    if (verb == "fault") {
        words >> word;
        if (!kTroubles.contains(word)) return false;
        played.trouble = kTroubles.at(word);
        played.next_us = g_get_monotonic_time();
        return true;
    }
    if (verb == "sent") {
        std::cout << played.sent << ' ';
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
