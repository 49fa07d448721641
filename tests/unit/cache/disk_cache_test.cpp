// SPDX-License-Identifier: Apache-2.0
#include "server/cache/disk_cache.h"

#include <gtest/gtest.h>

#include <fstream>

#include "server/cache/mesh_cache.h"
#include "server/cache/program_identity.h"
#include "tests/support/small_mesh.h"
#include "tests/support/temporary_folder.h"

namespace flare {
namespace {

using namespace std::chrono_literals;
using test::SameMesh;
using test::SmallMesh;
using test::TemporaryFolder;

const Fingerprint kKey{1, 2};

class DiskCacheTest : public testing::Test {
  protected:
    DiskCacheOptions Options() {
        DiskCacheOptions options;
        options.folder = folder_.path();
        options.max_bytes = 1'000'000;
        options.identity = {3, 4};
        options.log = [this](const std::string& text) { log_.push_back(text); };
        return options;
    }
    static void WriteNow(DiskCache& cache, const Fingerprint& key, const GhostMesh& mesh) {
        cache.Write(key, std::make_shared<const GhostMesh>(mesh));
        ASSERT_TRUE(cache.WaitUntilWritten(60s));
    }
    std::filesystem::path TheFile() {
        for (const auto& item : std::filesystem::directory_iterator(folder_.path())) {
            if (item.path().extension() == ".mesh") return item.path();
        }
        ADD_FAILURE() << "there is no mesh file";
        return {};
    }

    TemporaryFolder folder_;
    std::vector<std::string> log_;
};

TEST_F(DiskCacheTest, AMeshOutlivesTheProgram) {
    {
        DiskCache cache(Options());
        EXPECT_FALSE(cache.Read(kKey));
        cache.Write(kKey, std::make_shared<const GhostMesh>(SmallMesh()));
    }
    DiskCache cache(Options());
    const std::optional<GhostMesh> read = cache.Read(kKey);
    ASSERT_TRUE(read);
    EXPECT_TRUE(SameMesh(*read, SmallMesh()));
    EXPECT_FALSE(cache.Read({2, 1}));
    const DiskCacheStats stats = cache.stats();
    EXPECT_EQ(stats.hits, 1U);
    EXPECT_EQ(stats.misses, 1U);
    EXPECT_EQ(stats.discarded, 0U);
    EXPECT_EQ(stats.files, 1U);
    EXPECT_EQ(stats.read_bytes, std::filesystem::file_size(TheFile()));
    EXPECT_EQ(stats.file_bytes, stats.read_bytes);
}

TEST_F(DiskCacheTest, AnotherIdentitysMeshIsNotTaken) {
    DiskCache cache(Options());
    WriteNow(cache, kKey, SmallMesh());
    DiskCacheOptions other = Options();
    other.identity = {4, 3};
    EXPECT_FALSE(DiskCache(other).Read(kKey));
    EXPECT_EQ(ProgramIdentity(), ProgramIdentity());
    EXPECT_NE(ProgramIdentity(), Fingerprint{});
}

TEST_F(DiskCacheTest, ADamagedFileIsRemovedAndWrittenAnew) {
    DiskCache cache(Options());
    for (const auto& damage : {"cut", "flip", "foreign", "empty"}) {
        WriteNow(cache, kKey, SmallMesh());
        const std::filesystem::path file = TheFile();
        const std::string kind = damage;
        if (kind == "cut") std::filesystem::resize_file(file, 100);
        if (kind == "empty") std::filesystem::resize_file(file, 0);
        if (kind == "foreign") std::ofstream(file) << "somebody's notes";
        if (kind == "flip") {
            std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
            stream.seekp(200);
            stream.put('\x55');
        }
        EXPECT_FALSE(cache.Read(kKey)) << kind;
        EXPECT_FALSE(std::filesystem::exists(file)) << kind;
    }
    EXPECT_EQ(cache.stats().discarded, 4U);
    EXPECT_EQ(log_.size(), 1U) << "once";
    WriteNow(cache, kKey, SmallMesh());
    EXPECT_TRUE(cache.Read(kKey));
}

// The file of one mesh under the name of another, as after a slip of the file system.
TEST_F(DiskCacheTest, AFileUnderAnotherNameIsNotTaken) {
    DiskCache cache(Options());
    WriteNow(cache, kKey, SmallMesh());
    const std::filesystem::path first = TheFile();
    const std::filesystem::path aside = folder_ / "aside";
    std::filesystem::rename(first, aside);
    WriteNow(cache, {7, 7}, SmallMesh(9.0F));
    std::filesystem::copy_file(aside, TheFile(), std::filesystem::copy_options::overwrite_existing);
    EXPECT_FALSE(cache.Read({7, 7}));
    EXPECT_EQ(cache.stats().discarded, 1U);
}

TEST_F(DiskCacheTest, WhatFindsNoRoomInTheQueueIsDroppedAndCounted) {
    DiskCacheOptions options = Options();
    options.queue_bytes = SmallMesh().bytes() - 1;
    DiskCache cache(options);
    WriteNow(cache, kKey, SmallMesh());
    EXPECT_FALSE(cache.Read(kKey));
    EXPECT_EQ(cache.stats().dropped, 1U);
    EXPECT_EQ(cache.stats().writes, 0U);
}

TEST_F(DiskCacheTest, AFolderThatCannotBeWrittenCostsOneLineInTheLog) {
    std::ofstream(folder_ / "file") << "";
    DiskCacheOptions options = Options();
    options.folder = folder_ / "file/cache";
    DiskCache cache(options);
    for (std::uint64_t i = 0; i < 5; ++i) {
        WriteNow(cache, {i, i}, SmallMesh());
        EXPECT_FALSE(cache.Read({i, i}));
    }
    EXPECT_EQ(cache.stats().failed, 5U);
    ASSERT_EQ(log_.size(), 1U);
    EXPECT_NE(log_[0].find(options.folder), std::string::npos) << log_[0];
}

TEST_F(DiskCacheTest, TheBoundHolds) {
    DiskCacheOptions options = Options();
    options.max_bytes = 5'000;
    DiskCache cache(options);
    for (std::uint64_t i = 0; i < 20; ++i) {
        WriteNow(cache, {i, i}, SmallMesh());
        EXPECT_LE(cache.stats().file_bytes, 5'000U);
    }
    EXPECT_GT(cache.stats().evictions, 10U);
    EXPECT_TRUE(cache.Read({19, 19}));
    EXPECT_FALSE(cache.Read({0, 0}));
}

TEST_F(DiskCacheTest, TheMemoryCacheAsksTheDiskBeforeItTraces) {
    int built = 0;
    const auto build = [&built] {
        ++built;
        return SmallMesh();
    };
    {
        DiskCache disk(Options());
        MeshCache cache(1'000'000, &disk);
        const auto found = cache.Get(kKey, build, {});
        ASSERT_TRUE(found.ok());
        EXPECT_FALSE(found->hit);
        EXPECT_FALSE(found->from_disk);
        EXPECT_EQ(cache.rays_traced(), SmallMesh().rays_traced);
        ASSERT_TRUE(disk.WaitUntilWritten(60s));
    }
    DiskCache disk(Options());
    MeshCache cache(1'000'000, &disk);
    const auto found = cache.Get(kKey, build, {});
    ASSERT_TRUE(found.ok());
    EXPECT_TRUE(found->hit);
    EXPECT_TRUE(found->from_disk);
    EXPECT_TRUE(SameMesh(*found->mesh, SmallMesh()));
    const auto again = cache.Get(kKey, build, {});
    EXPECT_TRUE(again->hit);
    EXPECT_FALSE(again->from_disk) << "now it is in memory";
    EXPECT_EQ(built, 1);
    EXPECT_EQ(cache.rays_traced(), 0U);
    ASSERT_TRUE(disk.WaitUntilWritten(60s));
    EXPECT_EQ(disk.stats().writes, 0U) << "what came from disk is not written again";
}

}  // namespace
}  // namespace flare
