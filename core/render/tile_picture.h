// SPDX-License-Identifier: Apache-2.0
//
// The fast picture: colour only, in single precision. Smooth tiles are added up corner by corner
// and opened out to pixels once, whatever the number of ghosts; tiles on an edge are shaded pixel
// by pixel; what tiles cannot hold is drawn by exact polygons, as Picture does for everything. A
// strip of rows is one thread's own and takes ghost after ghost, so the sums do not depend on
// threads.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/parallel.h"
#include "core/image/ghost_tiles.h"

namespace flare {

// What polygons drew in a ghost's tiles that are left to them, to be drawn again without the ghost.
struct LeftPixels {
    LeftPixels() = default;
    // Room for those of `tiles`.
    explicit LeftPixels(const GhostTiles& tiles);
    // How many bytes that takes.
    static std::size_t BytesFor(const GhostTiles& tiles);

    std::vector<std::uint32_t> row_at;  // tiles before each row of tiles
    std::vector<float> rgb;             // [tile][channel][row][column]
};

// A ghost and its tiles.
struct TiledGhost {
    GhostLight light;
    std::shared_ptr<const GhostTiles> tiles;  // null: none of it reaches the picture
    const LeftPixels* left = nullptr;         // drawn before, in place of polygons
};

// The whole blocks of tiles that a window touches.
PixelWindow WholeBlocks(const PixelWindow& window);

class TilePicture {
  public:
    // Tiles are laid out from the middle of a frame of `width` x `height`, so that a symmetric
    // flare gives a symmetric picture. Light is held in units of `unit`: the brightest lamp's.
    TilePicture(const PixelWindow& window, int width, int height, double unit);

    // The map and the window that ghosts are cut into tiles by: from the frame's middle, the window
    // widened to whole blocks of tiles.
    PictureMap MapFromMiddle(PictureMap map) const;
    PixelWindow FromMiddle(const PixelWindow& window) const;
    const PixelWindow& padded() const { return padded_; }
    int middle_x() const { return middle_x_; }
    int middle_y() const { return middle_y_; }
    double unit() const { return unit_; }

    struct Drawn {
        std::uint64_t pieces = 0;     // polygons and tiles
        std::uint64_t fragments = 0;  // pixels they touched
    };
    // Adds the ghosts in the order given; `map` as MapFromMiddle gives it. Stops early when
    // cancelled. What polygons draw of a ghost goes to its place in `kept` as well, where that has
    // room.
    Drawn Draw(const std::vector<TiledGhost>& ghosts, const Iris& iris, const PictureMap& map,
               const WalkTolerance& tolerance, ThreadPool& threads, const CancelToken& cancel,
               std::span<LeftPixels> kept = {});

    // Back to darkness.
    void Clear();

    // Opens the smooth tiles out and hands over what has been drawn: red, green and blue of the
    // window, times `scale`, clamped to finite floats.
    std::array<std::vector<float>, 3> Resolve(double scale, ThreadPool& threads) const;

  private:
    struct Strip;
    struct Plane {
        int x0 = 0, y0 = 0, width = 0, height = 0;  // in tiles
        // [tile][corner][channel]; none until a tile comes, and no value before the tile is lit.
        std::unique_ptr<float[]> corners;
        std::vector<std::uint64_t> lit;  // [row][word]: a bit a tile
        int words() const { return (width + 63) / 64; }
    };

    void MakeRoom(const std::vector<TiledGhost>& ghosts);
    // Makes a strip's pixels dark, once.
    void Ink(const Strip& strip);
    void DrawSmooth(const GhostTiles& tiles, const Strip& strip, Drawn& drawn);
    void DrawEdges(const TiledGhost& ghost, const Iris& iris, const Strip& strip, Drawn& drawn);
    void DrawLeft(const TiledGhost& ghost, const Iris& iris, const PictureMap& map,
                  const WalkTolerance& tolerance, Strip& strip, LeftPixels* kept, Drawn& drawn);
    void DrawBlock(const TiledGhost& ghost, const PixelWindow& block, const Iris& iris,
                   const PictureMap& map, const WalkTolerance& tolerance, Strip& strip,
                   LeftPixels* kept, Drawn& drawn);
    void AddLeftTile(int x, int y, const float* rgb);
    void AddLeft(const TiledGhost& ghost, const Strip& strip, Drawn& drawn);
    void ResolveRow(int row, double factor, std::array<std::vector<float>, 3>& planes) const;
    float* Row(std::size_t channel, int y) {
        return pixels_[channel].get() +
               static_cast<std::size_t>(y - padded_.y) * static_cast<std::size_t>(padded_.width);
    }

    PixelWindow window_;  // from the frame's middle, like padded_
    PixelWindow padded_;
    int middle_x_ = 0, middle_y_ = 0;
    double unit_ = 1.0;
    std::array<Plane, kTileLevels> planes_;
    // Of padded_; a strip's have no value before it is inked.
    std::array<std::unique_ptr<float[]>, 3> pixels_;
    std::vector<std::uint8_t> inked_;
};

}  // namespace flare
