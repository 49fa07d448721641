// SPDX-License-Identifier: Apache-2.0
#include "core/render/blurred_ghosts.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/render/picture.h"

namespace flare {
namespace {

constexpr double kSeen_px = 0.2;      // a source's image of less is a point
constexpr double kFewer = 0.3;        // of directions along a side, when rounding up
constexpr double kWidest_px = 128.0;  // that a kernel may be on its own level
constexpr double kPartsShare = 0.7;   // of the blur, for what parts of a source add up to
constexpr std::size_t kTasksPerBatch = 12;
constexpr std::size_t kPixelsAtOnce = std::size_t{1} << 22;

// The semi-axes of the image of a disc, the smaller one first.
std::array<double, 2> SemiAxes(const GhostMotion& motion, double radius_rad) {
    const Vec2d& u = motion.along_u;
    const Vec2d& v = motion.along_v;
    const double square = u.length2() + v.length2();
    const double area = std::abs(u.x * v.y - u.y * v.x);
    const double spread = std::sqrt(std::max(0.0, square * square - 4.0 * area * area));
    const double larger = std::sqrt(0.5 * (square + spread));
    return {larger > 0.0 ? radius_rad * area / larger : 0.0, radius_rad * larger};
}

int CoarseFor(const std::array<double, 2>& semi, double least_px) {
    int coarse = 0;
    while (coarse < kCoarsest && (std::ldexp(semi[0], -coarse - 1) >= least_px ||
                                  std::ldexp(semi[1], -coarse) > kWidest_px)) {
        ++coarse;
    }
    return coarse;
}

int FloorShift(int value, int by) {
    return value >> by;
}

// The pixels of 2^coarse that a window of pixels touches.
PixelWindow Coarser(const PixelWindow& window, int coarse) {
    const int x0 = FloorShift(window.x, coarse);
    const int y0 = FloorShift(window.y, coarse);
    return {x0, y0, FloorShift(window.x + window.width - 1, coarse) + 1 - x0,
            FloorShift(window.y + window.height - 1, coarse) + 1 - y0};
}

// The pixels whose light a kernel brings into the window.
PixelWindow Reached(const PixelWindow& window, const BlurKernel& kernel) {
    return {window.x - (kernel.x0 + kernel.width - 1), window.y - (kernel.y0 + kernel.height - 1),
            window.width + kernel.width - 1, window.height + kernel.height - 1};
}

// Grows a box of pixels, in doubles so that nothing overflows.
struct Box {
    double x0 = 1e300, y0 = 1e300, x1 = -1e300, y1 = -1e300;
    void Add(double ax, double ay, double bx, double by) {
        x0 = std::min(x0, ax);
        y0 = std::min(y0, ay);
        x1 = std::max(x1, bx);
        y1 = std::max(y1, by);
    }
    PixelWindow Within(const PixelWindow& w) const {
        const double left = std::max(std::floor(x0), static_cast<double>(w.x));
        const double top = std::max(std::floor(y0), static_cast<double>(w.y));
        const double right = std::min(std::ceil(x1), static_cast<double>(w.x + w.width));
        const double bottom = std::min(std::ceil(y1), static_cast<double>(w.y + w.height));
        if (!(right > left && bottom > top)) return {};
        return {static_cast<int>(left), static_cast<int>(top), static_cast<int>(right - left),
                static_cast<int>(bottom - top)};
    }
};

Box BoxOfTiles(const GhostTiles& tiles) {
    Box box;
    const auto add = [&](int level, int x, int y) {
        const int size = TileSize(level);
        box.Add(x * size, y * size, (x + 1) * size, (y + 1) * size);
    };
    for (const SmoothTile& tile : tiles.smooth) add(tile.level, tile.x, tile.y);
    for (const EdgeTile& tile : tiles.edges) add(tile.level, tile.x, tile.y);
    if (tiles.any_left) {
        const int size = TileSize(kTileLevels - 1);
        box.Add(tiles.left_x * size, tiles.left_y * size, (tiles.left_x + tiles.left_width) * size,
                (tiles.left_y + tiles.left_height) * size);
    }
    return box;
}

}  // namespace

std::vector<BlurChoice> ChooseBlur(std::span<const PlannedGhost> ghosts, double radius_rad,
                                   const QualitySettings& settings) {
    double light = 0.0;
    double roots = 0.0;
    for (const PlannedGhost& ghost : ghosts) light += ghost.weight * ghost.sample.frame_light;
    const auto misplaced = [&](const PlannedGhost& ghost) {
        if (!ghost.motion || !ghost.motion->known || !(light > 0.0)) return 0.0;
        return ghost.motion->error * ghost.weight * ghost.sample.frame_light / light;
    };
    for (const PlannedGhost& ghost : ghosts) roots += std::sqrt(misplaced(ghost));
    std::vector<BlurChoice> choices;
    for (const PlannedGhost& ghost : ghosts) {
        BlurChoice& choice = choices.emplace_back();
        if (!ghost.motion || !ghost.motion->known) continue;
        const std::array<double, 2> semi = SemiAxes(*ghost.motion, radius_rad);
        if (semi[1] < kSeen_px) continue;
        // Errors fall with the number of directions; the fewest that keep their sum are those that
        // go with the root of each.
        const double directions = std::sqrt(misplaced(ghost)) * roots / settings.blur_tolerance;
        choice.side = std::clamp(static_cast<int>(std::ceil(std::sqrt(directions) - kFewer)), 1,
                                 settings.most_blur_side);
        // Parts of a source may be less than a pixel: it is their sum that has no detail.
        const double parts = choice.side > 1 ? kPartsShare : 1.0;
        choice.coarse = CoarseFor({semi[0] * parts, semi[1] * parts}, settings.least_blur_px);
    }
    return choices;
}

struct BlurredGhosts::Task {
    const Job* job = nullptr;
    std::size_t number = 0;  // of the job
    PlacedLight light;
    BlurKernel kernel;
    GhostCanvas canvas;
};

BlurredGhosts::BlurredGhosts(const RenderScene& scene, const RenderContext& context,
                             const GhostBuilder& builder, const GhostCanvas& canvas)
    : scene_(scene),
      context_(context),
      builder_(builder),
      canvas_(canvas),
      levels_({scene.window.x - canvas.origin_x, scene.window.y - canvas.origin_y,
               scene.window.width, scene.window.height},
              scene.channel_count()) {}

GhostCanvas BlurredGhosts::CanvasOf(const Task& task) const {
    GhostCanvas canvas = canvas_;
    canvas.coarse = task.job->choice.coarse;
    const PixelWindow frame{-canvas.origin_x, -canvas.origin_y, scene_.request.image.width,
                            scene_.request.image.height};
    canvas.frame = Reached(Coarser(frame, canvas.coarse), task.kernel);
    canvas.window = Reached(levels_.WindowOf(canvas.coarse), task.kernel);
    if (canvas.tiles) canvas.window = WholeBlocks(canvas.window);
    return canvas;
}

std::vector<BlurredGhosts::Drawn> BlurredGhosts::Add(const SourceDisc& disc,
                                                     const SourceSquare& part,
                                                     const PlacedLight& light,
                                                     std::span<const Job> jobs, bool with_flux,
                                                     Work& work) {
    std::vector<Task> tasks;
    for (std::size_t n = 0; n < jobs.size(); ++n) {
        const int side = jobs[n].choice.side;
        const GhostMotion& motion = *jobs[n].planned->motion;
        const double size = std::ldexp(1.0, -jobs[n].choice.coarse);
        const SourceImage image{motion.along_u * size, motion.along_v * size,
                                jobs[n].choice.coarse};
        for (int k = 0; k < side * side; ++k) {
            const SourceSquare square = part.Part(k % side, k / side, side);
            Task& task = tasks.emplace_back();
            task.job = &jobs[n];
            task.number = n;
            task.light = side == 1 ? light : disc.LightOf(square);
            task.kernel = KernelOf(disc.CellOf(square, light), image);
            task.canvas = CanvasOf(task);
        }
    }
    std::vector<Drawn> drawn(jobs.size());
    for (std::size_t first = 0; first < tasks.size(); first += kTasksPerBatch) {
        const std::size_t count = std::min(kTasksPerBatch, tasks.size() - first);
        const double t0 = context_.now_ms();
        std::vector<GhostBuilder::Built> built(count);
        context_.threads.For(static_cast<int>(count), [&](int i) {
            const auto n = static_cast<std::size_t>(i);
            const Task& task = tasks[first + n];
            built[n] = builder_.Build(task.light, *task.job->sequence, task.job->planned->weight,
                                      with_flux, task.canvas);
        });
        const double t1 = context_.now_ms();
        work.mesh_ms += t1 - t0;
        for (std::size_t n = 0; n < count; ++n) {
            const Task& task = tasks[first + n];
            Drawn& of = drawn[task.number];
            const double share = 1.0 / (task.job->choice.side * task.job->choice.side);
            of.miss = built[n].miss;
            of.dispersion_step_px = built[n].dispersion_step_px;
            of.flux_mm2 += share * built[n].flux_mm2;
            work.Add(built[n].work);
        }
        // As many at once as memory allows.
        for (std::size_t at = 0; at < count;) {
            std::size_t pixels = 0;
            std::size_t next = at;
            while (next < count &&
                   (next == at ||
                    pixels + tasks[first + next].canvas.window.pixels() <= kPixelsAtOnce)) {
                pixels += tasks[first + next].canvas.window.pixels();
                ++next;
            }
            if (context_.cancel.cancelled()) return drawn;
            std::vector<LightPlanes> planes(next - at);
            std::vector<Work> works(next - at);
            context_.threads.For(static_cast<int>(planes.size()), [&](int i) {
                const auto n = static_cast<std::size_t>(i);
                planes[n] = Draw(tasks[first + at + n], std::move(built[at + n].ghost), works[n]);
            });
            for (std::size_t n = 0; n < planes.size(); ++n) {
                work.Add(works[n]);
                if (planes[n].channels.empty()) continue;
                const Task& task = tasks[first + at + n];
                AddBlurred(planes[n], task.kernel, levels_.Level(task.canvas.coarse),
                           context_.threads);
            }
            at = next;
        }
        work.raster_ms += context_.now_ms() - t1;
    }
    return drawn;
}

LightPlanes BlurredGhosts::Draw(const Task& task, TiledGhost ghost, Work& work) const {
    if (ghost.light.cells.empty()) return {};
    const PictureMap map = task.canvas.MapOnto(MapOf(scene_.request, task.light.pose));
    return task.canvas.tiles ? DrawTiles(task, std::move(ghost), map, work)
                             : DrawPolygons(task, std::move(ghost), map, work);
}

LightPlanes BlurredGhosts::DrawTiles(const Task& task, TiledGhost ghost, const PictureMap& map,
                                     Work& work) const {
    LightPlanes planes;
    planes.window = BoxOfTiles(ghost.tiles).Within(task.canvas.window);
    if (planes.window.width == 0) return planes;
    planes.window = WithBlurMargin(planes.window, task.kernel);
    TilePicture picture(planes.window, 0, 0, task.canvas.unit);
    std::vector<TiledGhost> one;
    one.push_back(std::move(ghost));
    const TilePicture::Drawn drawn = picture.Draw(one, scene_.iris, map, scene_.settings.walk,
                                                  context_.threads, context_.cancel);
    work.polygons += drawn.pieces;
    work.fragments += drawn.fragments;
    std::array<std::vector<float>, 3> channels = picture.Resolve(1.0, context_.threads);
    for (std::vector<float>& channel : channels) planes.channels.push_back(std::move(channel));
    return planes;
}

LightPlanes BlurredGhosts::DrawPolygons(const Task& task, TiledGhost ghost, const PictureMap& map,
                                        Work& work) const {
    Box box;
    for (const GhostLight::Cell& cell : ghost.light.cells)
        box.Add(cell.x0, cell.y0, cell.x1, cell.y1);
    LightPlanes planes;
    planes.window = box.Within(task.canvas.window);
    if (planes.window.width == 0) return planes;
    planes.window = WithBlurMargin(planes.window, task.kernel);
    const bool spectral = scene_.spectral();
    Picture picture(planes.window, spectral ? static_cast<int>(scene_.channel_count()) : 0);
    std::vector<GhostLight> one;
    one.push_back(std::move(ghost.light));
    const Picture::Drawn drawn = picture.Draw(one, scene_.iris, map, scene_.settings.walk,
                                              context_.threads, context_.cancel);
    work.polygons += drawn.pieces;
    work.fragments += drawn.fragments;
    for (int c = 0; c < picture.channel_count(); ++c)
        planes.channels.push_back(picture.Channel(c, 1.0));
    return planes;
}

}  // namespace flare
