// SPDX-License-Identifier: Apache-2.0
#include "server/cache/cache_folder.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>

#include "tests/support/temporary_folder.h"

namespace flare {
namespace {

using test::TemporaryFolder;

Fingerprint Name(std::uint64_t i) {
    return {i * 0x9E3779B97F4A7C15U, i};
}

std::string Blob(std::uint64_t i, std::size_t bytes) {
    return std::string(bytes, static_cast<char>('a' + i % 26));
}

std::size_t FilesEndingWith(const std::string& folder, const std::string& ending) {
    std::size_t count = 0;
    for (const auto& item : std::filesystem::directory_iterator(folder)) {
        count += item.path().string().ends_with(ending) ? 1 : 0;
    }
    return count;
}

std::uint64_t BytesOfBlobs(const std::string& folder) {
    std::uint64_t bytes = 0;
    for (const auto& item : std::filesystem::directory_iterator(folder)) {
        std::error_code gone;  // another program may remove it while we look
        const std::uint64_t size = item.file_size(gone);
        if (item.path().extension() == ".mesh" && !gone) bytes += size;
    }
    return bytes;
}

void Write(const std::string& path, const std::string& text) {
    std::ofstream(path, std::ios::binary) << text;
}

TEST(CacheFolder, GivesBackWhatWasStoredAlsoAfterARestart) {
    const TemporaryFolder root;
    const std::string path = root / "not/there/yet";
    {
        CacheFolder folder(path, "mesh", 1000);
        EXPECT_FALSE(folder.Load(Name(1)));
        EXPECT_FALSE(std::filesystem::exists(path)) << "nothing is made before it is needed";
        EXPECT_FALSE(folder.Store(Name(1), Blob(1, 300)));
        EXPECT_FALSE(folder.Store(Name(2), Blob(2, 0)));
        EXPECT_EQ(folder.Load(Name(1)), Blob(1, 300));
        EXPECT_EQ(folder.Load(Name(2)), "");
    }
    CacheFolder folder(path, "mesh", 1000);
    EXPECT_EQ(folder.stats().bytes, 300U);
    EXPECT_EQ(folder.stats().entries, 2U);
    EXPECT_EQ(folder.Load(Name(1)), Blob(1, 300));
    folder.Discard(Name(1));
    EXPECT_FALSE(folder.Load(Name(1)));
    EXPECT_EQ(folder.stats().bytes, 0U);
    EXPECT_EQ(std::filesystem::status(path).permissions(), std::filesystem::perms::owner_all);
}

TEST(CacheFolder, TheLeastRecentlyUsedGoesFirst) {
    const TemporaryFolder root;
    CacheFolder folder(root.path(), "mesh", 1000);
    for (std::uint64_t i = 0; i < 3; ++i) EXPECT_FALSE(folder.Store(Name(i), Blob(i, 300)));
    EXPECT_TRUE(folder.Load(Name(0)));  // now 1 is the oldest
    EXPECT_FALSE(folder.Store(Name(3), Blob(3, 300)));
    EXPECT_FALSE(folder.Load(Name(1)));
    for (const std::uint64_t i : {0U, 2U, 3U}) EXPECT_TRUE(folder.Load(Name(i))) << i;
    EXPECT_EQ(folder.stats().evictions, 1U);
    EXPECT_EQ(BytesOfBlobs(root.path()), 900U);
    EXPECT_FALSE(folder.Store(Name(4), Blob(4, 1000))) << "the whole room for one";
    EXPECT_EQ(BytesOfBlobs(root.path()), 1000U);
    EXPECT_TRUE(folder.Store(Name(5), Blob(5, 1001))) << "never kept";
    EXPECT_TRUE(folder.Load(Name(4)));
}

TEST(CacheFolder, TheOrderOutlivesTheProgram) {
    const TemporaryFolder root;
    {
        CacheFolder folder(root.path(), "mesh", 1000);
        for (std::uint64_t i = 0; i < 3; ++i) EXPECT_FALSE(folder.Store(Name(i), Blob(i, 300)));
        EXPECT_TRUE(folder.Load(Name(0)));
    }
    CacheFolder folder(root.path(), "mesh", 600);  // a lower bound than before: one must go
    EXPECT_EQ(BytesOfBlobs(root.path()), 600U);
    EXPECT_FALSE(folder.Load(Name(1)));
    EXPECT_TRUE(folder.Load(Name(0)));
    EXPECT_TRUE(folder.Load(Name(2)));
}

TEST(CacheFolder, ReplacingABlobPushesOutNoOther) {
    const TemporaryFolder root;
    CacheFolder folder(root.path(), "mesh", 1000);
    EXPECT_FALSE(folder.Store(Name(1), Blob(1, 500)));
    EXPECT_FALSE(folder.Store(Name(2), Blob(2, 500)));
    EXPECT_FALSE(folder.Store(Name(1), Blob(3, 500)));
    EXPECT_EQ(folder.Load(Name(1)), Blob(3, 500));
    EXPECT_TRUE(folder.Load(Name(2)));
    EXPECT_EQ(folder.stats().bytes, 1000U);
    EXPECT_EQ(folder.stats().evictions, 0U);
}

TEST(CacheFolder, AnotherProgramsUseAndWritesCount) {
    const TemporaryFolder root;
    CacheFolder mine(root.path(), "mesh", 1000), other(root.path(), "mesh", 1000);
    EXPECT_FALSE(mine.Store(Name(1), Blob(1, 400)));
    EXPECT_FALSE(mine.Store(Name(2), Blob(2, 400)));
    EXPECT_TRUE(other.Load(Name(1))) << "no index is needed to find it";
    EXPECT_FALSE(mine.Store(Name(3), Blob(3, 400)));
    EXPECT_FALSE(mine.Load(Name(2))) << "the oldest, since the other program has read 1";
    EXPECT_TRUE(mine.Load(Name(1)));
    for (std::uint64_t i = 10; i < 20; ++i) {
        EXPECT_FALSE((i % 2 == 0 ? mine : other).Store(Name(i), Blob(i, 300)));
        EXPECT_LE(BytesOfBlobs(root.path()), 1000U);
    }
}

TEST(CacheFolder, LeavesAloneWhatIsNotItsOwn) {
    const TemporaryFolder root;
    const std::string hex = Name(1).hex();
    const std::string strangers[] = {root / "notes.mesh", root / (hex + ".txt"),
                                     root / (hex + "0.mesh"), root / "thesis.part",
                                     root / (std::string(32, 'x') + ".mesh")};
    for (const std::string& stranger : strangers) Write(stranger, Blob(1, 5000));
    std::filesystem::create_directory(root / (Name(7).hex() + ".mesh"));
    CacheFolder folder(root.path(), "mesh", 100);
    EXPECT_EQ(folder.stats().entries, 0U);
    EXPECT_FALSE(folder.Load(Name(7)));
    EXPECT_FALSE(folder.Store(Name(2), Blob(2, 60)));
    EXPECT_FALSE(folder.Store(Name(3), Blob(3, 60)));
    for (const std::string& stranger : strangers) {
        EXPECT_EQ(std::filesystem::file_size(stranger), 5000U) << stranger;
    }
    EXPECT_TRUE(folder.Store(Name(7), Blob(7, 10))) << "a folder is in the way";
}

TEST(CacheFolder, SweepsTemporariesOfTheDeadAndNotOfTheLiving) {
    const TemporaryFolder root;
    const std::string dead = root / (Name(1).hex() + ".1-0.part");
    const std::string living = root / (Name(2).hex() + ".2-0.part");
    Write(dead, "half");
    Write(living, "half");
    const int fd = open(living.c_str(), O_RDWR | O_CLOEXEC);
    ASSERT_EQ(flock(fd, LOCK_EX), 0);
    { const CacheFolder folder(root.path(), "mesh", 100); }
    EXPECT_FALSE(std::filesystem::exists(dead));
    EXPECT_TRUE(std::filesystem::exists(living));
    close(fd);
    { const CacheFolder folder(root.path(), "mesh", 100); }
    EXPECT_FALSE(std::filesystem::exists(living));
}

TEST(CacheFolder, AFolderThatCannotBeMadeIsAnErrorWithTheSystemsWords) {
    const TemporaryFolder root;
    Write(root / "file", "");
    CacheFolder folder(root / "file/cache", "mesh", 1000);
    EXPECT_FALSE(folder.Load(Name(1)));
    const std::optional<Error> error = folder.Store(Name(1), Blob(1, 10));
    ASSERT_TRUE(error);
    EXPECT_EQ(error->code, "cache_io");
    EXPECT_NE(error->message.find("Not a directory"), std::string::npos) << error->message;
}

TEST(CacheFolder, AWriteThatStopsHalfwayLeavesNothing) {
    const TemporaryFolder root;
    CacheFolder folder(root.path(), "mesh", 100'000);
    EXPECT_FALSE(folder.Store(Name(1), Blob(1, 10)));
    // As on a full disk: the first part of a write goes through, the rest does not.
    const auto before = std::signal(SIGXFSZ, SIG_IGN);
    rlimit unlimited{};
    getrlimit(RLIMIT_FSIZE, &unlimited);
    const rlimit tight{4096, unlimited.rlim_max};
    setrlimit(RLIMIT_FSIZE, &tight);
    const std::optional<Error> error = folder.Store(Name(2), Blob(2, 10'000));
    setrlimit(RLIMIT_FSIZE, &unlimited);
    std::signal(SIGXFSZ, before);
    EXPECT_TRUE(error);
    EXPECT_FALSE(folder.Load(Name(2)));
    EXPECT_TRUE(folder.Load(Name(1)));
    EXPECT_EQ(FilesEndingWith(root.path(), ".part"), 0U);
    EXPECT_FALSE(folder.Store(Name(2), Blob(2, 10'000))) << "room again";
}

TEST(CacheFolder, SurvivesItsFolderBeingRemoved) {
    const TemporaryFolder root;
    const std::string path = root / "cache";
    CacheFolder folder(path, "mesh", 1000);
    EXPECT_FALSE(folder.Store(Name(1), Blob(1, 600)));
    std::filesystem::remove_all(path);
    EXPECT_FALSE(folder.Load(Name(1)));
    EXPECT_FALSE(folder.Store(Name(2), Blob(2, 600)));
    EXPECT_EQ(folder.Load(Name(2)), Blob(2, 600));
    EXPECT_EQ(folder.stats().bytes, 600U) << "what is gone counts no more";
}

// What a program does that shares the folder: 0 if all it saw was right.
int Hammer(const std::string& path, std::uint64_t seed) {
    constexpr std::uint64_t kNames = 40, kBound = 20'000;
    CacheFolder folder(path, "mesh", kBound);
    std::uint64_t state = seed;
    for (int i = 0; i < 1500; ++i) {
        state = state * 6364136223846793005U + 1442695040888963407U;
        const std::uint64_t n = (state >> 33U) % kNames;
        const std::string blob = Blob(n, 500 + 70 * static_cast<std::size_t>(n));
        if ((state >> 20U) % 3 == 0) {
            if (folder.Store(Name(n), blob)) return 1;
            if (BytesOfBlobs(path) > kBound) return 2;
        } else if ((state >> 20U) % 97 == 1) {
            folder.Discard(Name(n));
        } else if (const auto read = folder.Load(Name(n)); read && *read != blob) {
            return 3;
        }
    }
    return 0;
}

TEST(CacheFolder, TwoProgramsHammerOneFolder) {
    const TemporaryFolder root;
    pid_t children[3] = {};
    for (pid_t& child : children) {
        child = fork();
        if (child == 0) _exit(Hammer(root.path(), static_cast<std::uint64_t>(getpid())));
        ASSERT_GT(child, 0);
    }
    for (const pid_t child : children) {
        int status = 0;
        ASSERT_EQ(waitpid(child, &status, 0), child);
        EXPECT_TRUE(WIFEXITED(status));
        EXPECT_EQ(WEXITSTATUS(status), 0) << "1: a store failed; 2: too many bytes; 3: a torn blob";
    }
    EXPECT_EQ(FilesEndingWith(root.path(), ".part"), 0U);
    EXPECT_GT(FilesEndingWith(root.path(), ".mesh"), 3U);
}

TEST(CacheFolder, ProgramsKilledWhileTheyWriteLeaveOnlyWholeBlobs) {
    const TemporaryFolder root;
    constexpr std::size_t kBytes = 400'000;
    for (int round = 0; round < 25; ++round) {
        const pid_t child = fork();
        if (child == 0) {
            CacheFolder folder(root.path(), "mesh", 8 * kBytes);
            for (std::uint64_t n = 0;; ++n) (void)folder.Store(Name(n % 20), Blob(n % 20, kBytes));
        }
        ASSERT_GT(child, 0);
        usleep(static_cast<useconds_t>(3000 + 700 * round));
        kill(child, SIGKILL);
        waitpid(child, nullptr, 0);
        EXPECT_LE(BytesOfBlobs(root.path()), 8 * kBytes);
        CacheFolder folder(root.path(), "mesh", 8 * kBytes);
        EXPECT_EQ(FilesEndingWith(root.path(), ".part"), 0U);
        for (std::uint64_t n = 0; n < 20; ++n) {
            const auto blob = folder.Load(Name(n));
            EXPECT_TRUE(!blob || *blob == Blob(n, kBytes)) << n;
        }
    }
    EXPECT_GT(FilesEndingWith(root.path(), ".mesh"), 0U) << "the children must have come to write";
}

}  // namespace
}  // namespace flare
