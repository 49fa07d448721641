// SPDX-License-Identifier: Apache-2.0
//
// With ZIP threads encode bands; each band is appended to the file as soon as all before it are, by
// whoever completes the row. So the bytes do not depend on the number of threads, and of a band
// only the encoded bytes ever stand in memory twice. Without compression every chunk's place is
// known, and threads write straight to it.
#include "core/image/exr.h"

#include <cstring>
#include <memory>
#include <mutex>
#include <numeric>
#include <utility>
#include <vector>

#include "core/base/check.h"
#include "core/image/exr_header.h"
#include "core/image/exr_lines.h"

namespace flare {
namespace {

// The file while bands come in, in any order.
class ExrFile {
  public:
    ExrFile(const ExrPlan& plan, const std::string& header, std::string memory)
        : plan_(plan),
          waiting_(static_cast<std::size_t>(plan.band_count())),
          table_at_(header.size()) {
        result_.bytes = std::move(memory);
        result_.bytes.clear();
        const auto chunks = static_cast<std::size_t>(plan.chunk_count());
        // Never more than this: a chunk that does not shrink is stored.
        result_.bytes.reserve(table_at_ + 8 * chunks + plan.stored_bytes());
        result_.bytes += header;
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

ExrBytes StoredExr(const ExrPlan& plan, const std::string& header, ThreadPool& threads,
                   std::string memory) {
    const auto count = static_cast<std::size_t>(plan.chunk_count());
    const std::size_t chunks_at = header.size() + 8 * count;
    ExrBytes result{std::move(memory)};
    // Used memory is not cleared: every byte is written below.
    result.bytes.resize(chunks_at + plan.stored_bytes());
    std::memcpy(result.bytes.data(), header.data(), header.size());
    for (std::size_t k = 0; k < count; ++k) {
        const std::uint64_t offset = chunks_at + k * (plan.stored_bytes() / count);
        std::memcpy(result.bytes.data() + header.size() + 8 * k, &offset, 8);
    }
    auto* const chunks = reinterpret_cast<unsigned char*>(result.bytes.data() + chunks_at);
    std::vector<std::uint64_t> saturated(static_cast<std::size_t>(plan.band_count()));
    threads.For(plan.band_count(), [&](int band) {
        saturated[static_cast<std::size_t>(band)] = ExrBandEncoder(plan).StoreInFile(band, chunks);
    });
    result.saturated_pixels = std::accumulate(saturated.begin(), saturated.end(), std::uint64_t{0});
    return result;
}

}  // namespace

ExrBytes EncodeExr(const FlareImage& image, const ExrOptions& options, ThreadPool& threads,
                   std::string memory) {
    const ExrPlan plan(image, options);
    if (!plan.zip()) {
        return StoredExr(plan, ExrHeader(image, options), threads, std::move(memory));
    }
    ExrFile file(plan, ExrHeader(image, options), std::move(memory));
    threads.For(plan.band_count(), [&](int index) {
        std::unique_ptr<ExrBandEncoder> encoder = file.TakeEncoder();
        std::unique_ptr<ExrBand> band = file.TakeBand();
        encoder->Encode(index, *band);
        file.Put(index, std::move(band), std::move(encoder));
    });
    return file.Take();
}

}  // namespace flare
