// SPDX-License-Identifier: Apache-2.0
#include "server/config.h"

#include <gtest/gtest.h>

namespace flare {
namespace {

TEST(Config, EveryNumberOfTheTableCanBeSet) {
    for (const Parameter& parameter : Parameters()) {
        const std::int64_t value = parameter.high;
        const auto config =
            ReadConfig(std::string(parameter.name) + " = " + std::to_string(value), {});
        ASSERT_TRUE(config.ok()) << parameter.name;
        EXPECT_EQ((*config).*parameter.member, value) << parameter.name;
    }
}

TEST(Config, DefaultsLieInTheirOwnRanges) {
    const Config defaults;
    for (const Parameter& parameter : Parameters()) {
        EXPECT_TRUE(CheckParameter(parameter, defaults.*parameter.member).ok()) << parameter.name;
    }
    EXPECT_TRUE(CheckConfig(defaults).ok());
}

TEST(Config, ReadsTheRest) {
    const auto config = ReadConfig(R"(
listen = ["unix:/run/f.sock", "http://127.0.0.1:0"]
lenses = "/srv/lenses"
disk_cache = "/var/cache/f"
log_level = "debug"
socket_mode = "0660"
allow_remote = true
)",
                                   {});
    ASSERT_TRUE(config.ok());
    EXPECT_EQ(config->listen, (std::vector<std::string>{"unix:/run/f.sock", "http://127.0.0.1:0"}));
    EXPECT_EQ(config->lenses, "/srv/lenses");
    EXPECT_EQ(config->disk_cache, "/var/cache/f");
    EXPECT_EQ(config->log_level, "debug");
    EXPECT_EQ(config->socket_mode_bits(), 0660U);
    EXPECT_TRUE(config->allow_remote);
}

TEST(Config, SaysWhereItIsWrong) {
    const struct {
        const char* text;
        const char* where;
    } kBad[] = {
        {"workers = 2\nworkerz = 2", "line 2, column 1"},
        {"workers = \"two\"", "line 1, column 1"},
        {"workers = 2.5", "line 1, column 1"},
        {"workers = -1", "line 1, column 1"},
        {"\n\n  queue = 0", "line 3, column 3"},
        {"queue = 1\nqueue = 2", "line 2, column 9"},
        {"listen = \"unix:/x\"", "line 1, column 1"},
        {"listen = [1]", "line 1, column 1"},
        {"allow_remote = 1", "line 1, column 1"},
        {"[http]\nqueue = 1", "line 1, column 2"},
        {"lenses = 1", "line 1, column 1"},
        {"disk_cache = true", "line 1, column 1"},
        {"queue = ", "line 1, column 9"},
    };
    for (const auto& row : kBad) {
        const auto config = ReadConfig(row.text, {});
        ASSERT_FALSE(config.ok()) << row.text;
        EXPECT_EQ(config.error().code, "bad_config") << row.text;
        EXPECT_EQ(config.error().where, row.where) << row.text << ": " << config.error().message;
    }
}

TEST(Config, ChecksTextsWhereverTheyCameFrom) {
    Config bad_level, bad_mode, no_address;
    bad_level.log_level = "loud";
    bad_mode.socket_mode = "rw";
    no_address.listen.clear();
    EXPECT_EQ(CheckConfig(bad_level).error().where, "log_level");
    EXPECT_EQ(CheckConfig(bad_mode).error().where, "socket_mode");
    EXPECT_EQ(CheckConfig(no_address).error().where, "listen");
}

TEST(Config, TheMachineFillsInWhatWasLeftToIt) {
    const Config config = FillFromMachine({});
    EXPECT_GE(config.threads, 1);
    EXPECT_GE(config.workers, 1);
    EXPECT_GE(config.picture_mb, 256);
    Config set;
    set.threads = 7;
    EXPECT_EQ(FillFromMachine(set).threads, 7);
}

}  // namespace
}  // namespace flare
