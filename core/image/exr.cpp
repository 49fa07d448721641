// SPDX-License-Identifier: Apache-2.0
//
// Threads encode bands; each band is appended to the file as soon as all before it are, by whoever
// completes the row. So the bytes do not depend on the number of threads, and of a band only the
// encoded bytes ever stand in memory twice.
#include "core/image/exr.h"

#include <cstring>
#include <mutex>
#include <utility>

#include "core/base/check.h"
#include "core/image/exr_header.h"
#include "core/image/exr_lines.h"

namespace flare {
namespace {

// The file while bands come in, in any order.
class ExrFile {
  public:
    ExrFile(const ExrPlan& plan, std::string header)
        : plan_(plan),
          waiting_(static_cast<std::size_t>(plan.band_count())),
          table_at_(header.size()) {
        result_.bytes = std::move(header);
        const auto chunks = static_cast<std::size_t>(plan.chunk_count());
        const auto lines = static_cast<std::size_t>(plan.image.data.height);
        // Never more than this: a chunk that does not shrink is stored.
        result_.bytes.reserve(table_at_ + 16 * chunks + plan.line_bytes() * lines);
        result_.bytes.append(8 * chunks, '\0');
    }

    // A band and an encoder that nobody uses, or new ones.
    std::unique_ptr<ExrBandEncoder> TakeEncoder() {
        const std::lock_guard lock(mutex_);
        if (encoders_.empty()) return std::make_unique<ExrBandEncoder>(plan_);
        return TakeLast(encoders_);
    }
    std::unique_ptr<ExrBand> TakeBand() {
        const std::lock_guard lock(mutex_);
        if (bands_.empty()) return std::make_unique<ExrBand>();
        return TakeLast(bands_);
    }

    void Put(int index, std::unique_ptr<ExrBand> band, std::unique_ptr<ExrBandEncoder> encoder) {
        const std::lock_guard lock(mutex_);
        encoders_.push_back(std::move(encoder));
        waiting_[static_cast<std::size_t>(index)] = std::move(band);
        while (next_ < waiting_.size() && waiting_[next_]) {
            Append(*waiting_[next_]);
            bands_.push_back(std::move(waiting_[next_]));
            ++next_;
        }
    }

    ExrBytes Take() {
        FLARE_CHECK(next_ == waiting_.size());
        return std::move(result_);
    }

  private:
    template <class T>
    static T TakeLast(std::vector<T>& from) {
        T last = std::move(from.back());
        from.pop_back();
        return last;
    }

    void Append(const ExrBand& band) {
        for (std::size_t at = 0; at < band.size;) {
            const std::uint64_t offset = result_.bytes.size() + at;
            std::memcpy(result_.bytes.data() + table_at_, &offset, 8);
            table_at_ += 8;
            std::int32_t size = 0;
            std::memcpy(&size, band.bytes.data() + at + 4, 4);
            at += 8 + static_cast<std::size_t>(size);
        }
        result_.bytes.append(reinterpret_cast<const char*>(band.bytes.data()), band.size);
        result_.saturated_pixels += band.saturated_pixels;
    }

    const ExrPlan& plan_;
    std::mutex mutex_;
    std::vector<std::unique_ptr<ExrBandEncoder>> encoders_;
    std::vector<std::unique_ptr<ExrBand>> bands_;
    std::vector<std::unique_ptr<ExrBand>> waiting_;
    std::size_t next_ = 0;      // the first band that is not in the file
    std::size_t table_at_ = 0;  // where the next chunk's offset goes
    ExrBytes result_;
};

}  // namespace

ExrBytes EncodeExr(const FlareImage& image, const ExrOptions& options, ThreadPool& threads) {
    const ExrPlan plan(image, options);
    ExrFile file(plan, ExrHeader(image, options));
    threads.For(plan.band_count(), [&](int index) {
        std::unique_ptr<ExrBandEncoder> encoder = file.TakeEncoder();
        std::unique_ptr<ExrBand> band = file.TakeBand();
        encoder->Encode(index, *band);
        file.Put(index, std::move(band), std::move(encoder));
    });
    return file.Take();
}

}  // namespace flare
