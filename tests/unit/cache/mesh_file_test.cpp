// SPDX-License-Identifier: Apache-2.0
#include "server/cache/mesh_file.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <random>

#include "tests/support/small_mesh.h"

namespace flare {
namespace {

using test::SameMesh;
using test::SmallMesh;

const Fingerprint kKey{0x0123456789abcdefU, 0xfedcba9876543210U};

std::uint64_t NumberAt(const std::string& file, std::size_t at, std::size_t bytes) {
    std::uint64_t value = 0;
    for (std::size_t i = bytes; i-- > 0;) {
        value = value << 8U | static_cast<unsigned char>(file[at + i]);
    }
    return value;
}

void PutNumber(std::string& file, std::size_t at, std::uint64_t value) {
    for (std::size_t i = 0; i < 8; ++i) {
        file[at + i] = static_cast<char>(static_cast<unsigned char>(value >> (8 * i)));
    }
}

// A damaged file whose checksum is right: what only the structure's own checks can refuse.
void MendChecksum(std::string& file) {
    const std::string_view all = file;
    const Fingerprint sum =
        Fingerprinter().Add(all.substr(0, 40)).Add(all.substr(kMeshFileHeaderBytes)).value();
    PutNumber(file, 40, sum.high);
    PutNumber(file, 48, sum.low);
}

// All that code which draws a mesh relies on, so that it never reads past an end.
bool Sound(const GhostMesh& mesh) {
    for (const MeshGrid& grid : mesh.grids) {
        const auto vertices = static_cast<std::size_t>(grid.nu) * static_cast<std::size_t>(grid.nv);
        if (grid.nu < 2 || grid.nv < 2 || grid.alive.size() != vertices || grid.nodes.empty() ||
            grid.nodes.size() != mesh.grids.front().nodes.size() ||
            grid.cells.size() !=
                static_cast<std::size_t>(grid.nu - 1) * static_cast<std::size_t>(grid.nv - 1)) {
            return false;
        }
        for (const MeshNode& node : grid.nodes) {
            if (node.fields.size() != vertices * static_cast<std::size_t>(mesh.stored_count()) ||
                node.passage.size() != vertices * static_cast<std::size_t>(mesh.passage_count())) {
                return false;
            }
        }
    }
    for (const auto* list : {&mesh.rims, &mesh.absorbing}) {
        for (const int step : *list) {
            if (step < 0 || step >= mesh.interactions) return false;
        }
    }
    return true;
}

TEST(MeshFile, GivesBackEveryValue) {
    const GhostMesh mesh = SmallMesh();
    const Result<GhostMesh> read = DecodeMesh(kKey, EncodeMesh(kKey, mesh));
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_TRUE(SameMesh(*read, mesh));
    EXPECT_TRUE(Sound(*read));
    GhostMesh other = mesh;
    other.grids[1].nodes[1].passage.back() += 1.0F;
    EXPECT_FALSE(SameMesh(*read, other)) << "the comparison must see single values";
}

TEST(MeshFile, GivesBackAMeshThatNothingPasses) {
    GhostMesh mesh;
    mesh.sequence = {3, 1};
    mesh.rays_traced = 77;
    const Result<GhostMesh> read = DecodeMesh(kKey, EncodeMesh(kKey, mesh));
    ASSERT_TRUE(read.ok());
    EXPECT_TRUE(SameMesh(*read, mesh));
}

TEST(MeshFile, KeepsEveryBitOfAFloat) {
    GhostMesh mesh = SmallMesh();
    std::vector<float>& fields = mesh.grids[0].nodes[0].fields;
    fields[0] = -0.0F;
    fields[1] = std::numeric_limits<float>::denorm_min();
    fields[2] = std::numeric_limits<float>::quiet_NaN();
    fields[3] = -std::numeric_limits<float>::infinity();
    const Result<GhostMesh> read = DecodeMesh(kKey, EncodeMesh(kKey, mesh));
    ASSERT_TRUE(read.ok());
    EXPECT_EQ(std::memcmp(read->grids[0].nodes[0].fields.data(), fields.data(),
                          fields.size() * sizeof(float)),
              0);
}

// The layout is a promise to files that exist: docs/mesh-files.md.
TEST(MeshFile, HasTheLayoutOfItsDescription) {
    const GhostMesh mesh = SmallMesh();
    const std::string file = EncodeMesh(kKey, mesh);
    EXPECT_EQ(file.substr(0, 8), "FLRMESH\n");
    EXPECT_EQ(NumberAt(file, 8, 4), 1U);
    EXPECT_EQ(NumberAt(file, 12, 4), 0U);
    EXPECT_EQ(NumberAt(file, 16, 8), kKey.high);
    EXPECT_EQ(NumberAt(file, 24, 8), kKey.low);
    EXPECT_EQ(NumberAt(file, 32, 8), file.size() - 56);
    EXPECT_EQ(NumberAt(file, 56, 8), 2U) << "reflections";
    EXPECT_EQ(NumberAt(file, 64, 4), 5U);
    EXPECT_EQ(NumberAt(file, 68, 4), 2U);
    double field_rad = 0.0;
    const std::uint64_t bits = NumberAt(file, 72, 8);
    std::memcpy(&field_rad, &bits, sizeof bits);
    EXPECT_EQ(field_rad, 0.1);
    // Per grid: 4 f64, 2 i32, u8, alive bits, cells at two bits, u64, and per node f64 and floats:
    // 7 stored fields and 3 passages a vertex.
    const std::size_t head = 8 + 2 * 4 + 3 * 8 + 2 * 4 + (8 + 4) * 2 + 2 * 8 + 1 + 8;
    const std::size_t grid1 = 41 + 1 + 1 + 8 + 2 * (8 + 6 * 10 * 4);
    const std::size_t grid2 = 41 + 1 + 1 + 8 + 2 * (8 + 4 * 10 * 4);
    EXPECT_EQ(file.size(), 56 + head + grid1 + grid2);
}

TEST(MeshFile, RefusesEveryLengthButItsOwn) {
    const std::string file = EncodeMesh(kKey, SmallMesh());
    for (std::size_t length = 0; length < file.size(); ++length) {
        const Result<GhostMesh> read = DecodeMesh(kKey, file.substr(0, length));
        ASSERT_FALSE(read.ok()) << length;
        EXPECT_EQ(read.error().code, "bad_mesh_file");
    }
    EXPECT_FALSE(DecodeMesh(kKey, file + '\0').ok());
    EXPECT_FALSE(DecodeMesh(kKey, file + file).ok());
}

TEST(MeshFile, RefusesEveryFlippedBit) {
    const std::string file = EncodeMesh(kKey, SmallMesh());
    for (std::size_t at = 0; at < file.size(); ++at) {
        for (unsigned bit = 0; bit < 8; ++bit) {
            std::string damaged = file;
            damaged[at] = static_cast<char>(static_cast<unsigned char>(damaged[at]) ^ (1U << bit));
            ASSERT_FALSE(DecodeMesh(kKey, damaged).ok()) << at << " " << bit;
        }
    }
}

TEST(MeshFile, RefusesAnotherKeysMesh) {
    const std::string file = EncodeMesh(kKey, SmallMesh());
    EXPECT_FALSE(DecodeMesh({kKey.high, kKey.low + 1}, file).ok());
    EXPECT_FALSE(DecodeMesh({kKey.low, kKey.high}, file).ok());
    EXPECT_FALSE(DecodeMesh({}, file).ok());
}

TEST(MeshFile, StaysSoundWhenTheChecksumIsRightAndTheRestIsNot) {
    const std::string file = EncodeMesh(kKey, SmallMesh());
    int refused = 0;
    for (std::size_t at = kMeshFileHeaderBytes; at < file.size(); ++at) {
        for (const unsigned value : {0x00U, 0x01U, 0x7fU, 0x80U, 0xffU}) {
            std::string damaged = file;
            damaged[at] = static_cast<char>(static_cast<unsigned char>(value));
            MendChecksum(damaged);
            const Result<GhostMesh> read = DecodeMesh(kKey, damaged);
            if (read) {
                ASSERT_TRUE(Sound(*read)) << at;
            } else {
                ++refused;
            }
        }
    }
    EXPECT_GT(refused, 100) << "counts and sizes must have been met";
    for (std::size_t length = kMeshFileHeaderBytes; length < file.size(); ++length) {
        std::string damaged = file.substr(0, length);
        PutNumber(damaged, 32, length - kMeshFileHeaderBytes);
        MendChecksum(damaged);
        ASSERT_FALSE(DecodeMesh(kKey, damaged).ok()) << length;
    }
}

// 2^31 vertices and more in a file of some hundred bytes: to be refused before memory is taken.
TEST(MeshFile, TakesNoMemoryForSizesThatAreNotThere) {
    const std::string file = EncodeMesh(kKey, SmallMesh());
    const std::size_t sequence = kMeshFileHeaderBytes;
    const std::size_t grids = sequence + 8 + 2 * 4 + 3 * 8 + 2 * 4 + (8 + 4) * 2 + 2 * 8 + 1;
    const std::size_t sides = grids + 8 + 4 * 8;
    ASSERT_EQ(NumberAt(file, grids, 8), 2U);
    ASSERT_EQ(NumberAt(file, sides, 4), 3U);
    for (const std::size_t at : {sequence, grids, sides}) {
        for (const std::uint64_t count : {std::uint64_t{1} << 30, std::uint64_t{1} << 61,
                                          ~std::uint64_t{0}, 0x7fffffff7fffffffU}) {
            std::string damaged = file;
            PutNumber(damaged, at, count);
            MendChecksum(damaged);
            EXPECT_FALSE(DecodeMesh(kKey, damaged).ok()) << at << " " << count;
        }
    }
}

TEST(MeshFile, RefusesNoise) {
    std::mt19937 random(7);
    const std::string file = EncodeMesh(kKey, SmallMesh());
    for (int i = 0; i < 20'000; ++i) {
        std::string noise = file.substr(0, kMeshFileHeaderBytes);
        noise.resize(kMeshFileHeaderBytes + random() % 400);
        for (std::size_t at = kMeshFileHeaderBytes; at < noise.size(); ++at) {
            // Mostly zeros, as counts are, so that some noise gets past the first of them.
            noise[at] = random() % 4 == 0 ? static_cast<char>(random() % 4) : '\0';
        }
        PutNumber(noise, 32, noise.size() - kMeshFileHeaderBytes);
        ASSERT_FALSE(DecodeMesh(kKey, noise).ok()) << "the checksum";
        MendChecksum(noise);
        const Result<GhostMesh> read = DecodeMesh(kKey, noise);
        ASSERT_TRUE(!read || Sound(*read)) << i;
    }
}

}  // namespace
}  // namespace flare
