// SPDX-License-Identifier: Apache-2.0
#include "server/http/listening_socket.h"

#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace flare {
namespace {

class ListeningSocketTest : public testing::Test {
  protected:
    void SetUp() override {
        std::string pattern = testing::TempDir() + "flaredXXXXXX";
        ASSERT_NE(mkdtemp(pattern.data()), nullptr);
        folder_ = pattern;
        path_ = folder_ + "/s.sock";
        url_ = "unix:" + path_;
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    std::string folder_, path_, url_;
};

TEST_F(ListeningSocketTest, MakesAndRemovesTheFileOfAUnixSocket) {
    {
        const auto socket = ListeningSocket::Open(url_, {});
        ASSERT_TRUE(socket.ok()) << socket.error().message;
        EXPECT_EQ(socket->url(), url_);
        struct stat status {};
        ASSERT_EQ(stat(path_.c_str(), &status), 0);
        EXPECT_EQ(status.st_mode & 0777U, 0600U);
    }
    EXPECT_FALSE(std::filesystem::exists(path_));
}

TEST_F(ListeningSocketTest, GivesTheFileThePermissionsAskedFor) {
    const auto socket = ListeningSocket::Open(url_, {.socket_mode = 0660});
    ASSERT_TRUE(socket.ok());
    struct stat status {};
    ASSERT_EQ(stat(path_.c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777U, 0660U);
}

TEST_F(ListeningSocketTest, DoesNotTakeAPathThatIsInUse) {
    const auto first = ListeningSocket::Open(url_, {});
    ASSERT_TRUE(first.ok());
    const auto second = ListeningSocket::Open(url_, {});
    ASSERT_FALSE(second.ok());
    EXPECT_EQ(second.error().code, "cannot_listen");
    EXPECT_TRUE(std::filesystem::exists(path_));
}

TEST_F(ListeningSocketTest, ReplacesASocketThatNobodyListensOn) {
    const std::string saved = folder_ + "/kept";
    {
        const auto dead = ListeningSocket::Open(url_, {});
        ASSERT_TRUE(dead.ok());
        std::filesystem::rename(path_, saved);  // so that its end does not remove it
    }
    std::filesystem::rename(saved, path_);
    EXPECT_TRUE(ListeningSocket::Open(url_, {}).ok());
}

TEST_F(ListeningSocketTest, LeavesFilesThatAreNoSocketsAlone) {
    std::ofstream(path_) << "precious";
    const auto socket = ListeningSocket::Open(url_, {});
    ASSERT_FALSE(socket.ok());
    EXPECT_EQ(std::filesystem::file_size(path_), 8U);
}

TEST_F(ListeningSocketTest, RemovesOnlyItsOwnFile) {
    {
        const auto socket = ListeningSocket::Open(url_, {});
        ASSERT_TRUE(socket.ok());
        std::filesystem::remove(path_);
        std::ofstream(path_) << "somebody else's";
    }
    EXPECT_TRUE(std::filesystem::exists(path_));
}

TEST(ListeningSocket, ChoosesAPortAndSaysWhich) {
    for (const char* url : {"http://127.0.0.1:0", "http://localhost:0", "http://[::1]:0"}) {
        const auto socket = ListeningSocket::Open(url, {});
        if (!socket && std::string(url).find("::1") != std::string::npos) continue;  // no IPv6
        ASSERT_TRUE(socket.ok()) << url << ": " << socket.error().message;
        EXPECT_NE(socket->url().substr(socket->url().rfind(':')), ":0");
    }
}

TEST(ListeningSocket, DoesNotOpenToOtherMachinesUnlessMeant) {
    const auto refused = ListeningSocket::Open("http://0.0.0.0:0", {});
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, "bad_address");
    EXPECT_TRUE(ListeningSocket::Open("http://0.0.0.0:0", {.allow_remote = true}).ok());
}

TEST(ListeningSocket, RefusesWhatIsNoAddress) {
    const std::string too_long = "unix:/" + std::string(120, 'x');
    for (const std::string& url :
         {std::string(""), std::string("unix:"), too_long, std::string("127.0.0.1:80"),
          std::string("https://127.0.0.1:1"), std::string("http://127.0.0.1"),
          std::string("http://127.0.0.1:99999"), std::string("http://127.0.0.1:-1"),
          std::string("http://example.com:80"), std::string("http://127.0.0.1:80x")}) {
        const auto socket = ListeningSocket::Open(url, {});
        ASSERT_FALSE(socket.ok()) << url;
        EXPECT_EQ(socket.error().code, "bad_address") << url;
    }
}

}  // namespace
}  // namespace flare
