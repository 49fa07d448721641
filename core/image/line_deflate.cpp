// SPDX-License-Identifier: Apache-2.0
//
// Numbers of sections are those of RFC 1951. A block is scanned for copies, its symbols are
// counted, and with the codes made from the counts its size is known before a bit is written.
#include "core/image/line_deflate.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <optional>
#include <utility>

#include "core/base/check.h"
#include "core/image/huffman_code.h"

namespace flare {
namespace {

constexpr std::size_t kLongestCopy = 258, kShortestCopy = 3;
// Shorter runs make the file larger as well as slower: frequent values have short codes.
constexpr std::size_t kShortestRun = 8;
constexpr std::size_t kWindow = 32768;
// Input of one block at the most: bounds the list of copies. A chunk of 1080p has half as much.
constexpr std::size_t kBlockBytes = std::size_t{1} << 19;
constexpr std::size_t kEndOfBlock = 256, kFirstLength = 257;
constexpr std::size_t kLiteralSymbols = 286, kDistanceSymbols = 30;
// Four literals and the rest of a byte fit into a word of 64 bits.
constexpr int kLongestCode = 14;
constexpr int kLongestLengthCode = 7;
constexpr std::array<std::uint8_t, 19> kLengthCodeOrder = {16, 17, 18, 0, 8,  7, 9,  6, 10, 5,
                                                           11, 4,  12, 3, 13, 2, 14, 1, 15};

// 3.2.5: a length or distance as a symbol and extra bits.
struct Part {
    std::uint16_t symbol;
    std::uint16_t extra;
    std::uint8_t extra_bits;
};

// Both kinds of symbol double their reach every 2^steps_log2 symbols; `value` counts from 0.
constexpr Part PartOf(std::size_t value, int steps_log2) {
    const auto v = static_cast<unsigned>(value);
    if (v < (2u << steps_log2)) return {static_cast<std::uint16_t>(v), 0, 0};
    const int bits = std::bit_width(v) - 1 - steps_log2;
    const unsigned step = v >> bits;  // in [2^steps_log2, 2^(steps_log2 + 1))
    return {static_cast<std::uint16_t>((static_cast<unsigned>(bits) << steps_log2) + step),
            static_cast<std::uint16_t>(v & ((1u << bits) - 1)), static_cast<std::uint8_t>(bits)};
}

constexpr Part LengthPart(std::size_t length) {
    if (length == kLongestCopy) return {285, 0, 0};
    Part part = PartOf(length - kShortestCopy, 2);
    part.symbol = static_cast<std::uint16_t>(part.symbol + kFirstLength);
    return part;
}

constexpr Part DistancePart(std::size_t distance) {
    return PartOf(distance - 1, 1);
}

// Calls use(length) for the lengths, each from 3 to 258, into which a copy is divided.
template <class Use>
void ForEachPiece(std::size_t length, Use use) {
    while (length > 0) {
        std::size_t piece = std::min(length, kLongestCopy);
        if (length > piece && length - piece < kShortestCopy) piece -= kShortestCopy;
        use(piece);
        length -= piece;
    }
}

// Bits go into bytes from the lowest on (3.1.1).
class BitWriter {
  public:
    explicit BitWriter(unsigned char* to) : to_(to) {}

    // Up to 56 bits may be put between two flushes.
    void Put(std::uint64_t bits, int count) {
        word_ |= bits << held_;
        held_ += count;
    }
    void Flush() {
        std::memcpy(to_, &word_, 8);
        to_ += held_ >> 3;
        word_ >>= held_ & ~7;
        held_ &= 7;
    }
    void PadToByte() { held_ = (held_ + 7) & ~7; }
    unsigned char* end() const { return to_; }

  private:
    unsigned char* to_;
    std::uint64_t word_ = 0;
    int held_ = 0;
};

std::uint64_t Cost(const std::vector<std::uint32_t>& counts, const HuffmanCode& code) {
    std::uint64_t bits = 0;
    for (std::size_t s = 0; s < counts.size(); ++s) {
        bits += std::uint64_t{counts[s]} * code.lengths[s];
    }
    return bits;
}

// 3.2.7: the lengths of both codes as symbols; runs of zeros are shortened.
struct LengthList {
    std::vector<Part> parts;
    HuffmanCode code;
    std::size_t codes = 19;  // of which the lengths are written
    std::uint64_t bits = 0;

    LengthList(const HuffmanCode& literals, const HuffmanCode& distances) {
        std::vector<std::uint8_t> lengths = literals.lengths;
        lengths.insert(lengths.end(), distances.lengths.begin(), distances.lengths.end());
        for (std::size_t i = 0; i < lengths.size();) {
            std::size_t zeros = 0;
            while (zeros < 138 && i + zeros < lengths.size() && lengths[i + zeros] == 0) ++zeros;
            if (zeros >= 11) {
                parts.push_back({18, static_cast<std::uint16_t>(zeros - 11), 7});
            } else if (zeros >= 3) {
                parts.push_back({17, static_cast<std::uint16_t>(zeros - 3), 3});
            } else {
                parts.push_back({lengths[i], 0, 0});
                zeros = 1;
            }
            i += zeros;
        }
        std::vector<std::uint32_t> counts(kLengthCodeOrder.size(), 0);
        for (const Part& part : parts) {
            ++counts[part.symbol];
            bits += part.extra_bits;
        }
        code = MakeHuffmanCode(counts, kLongestLengthCode);
        while (codes > 4 && code.lengths[kLengthCodeOrder[codes - 1]] == 0) --codes;
        bits += Cost(counts, code) + 5 + 5 + 4 + 3 * codes;
    }

    void Write(BitWriter& out) const {
        out.Put(kLiteralSymbols - 257, 5);
        out.Put(kDistanceSymbols - 1, 5);
        out.Put(codes - 4, 4);
        out.Flush();
        for (std::size_t k = 0; k < codes; ++k) {
            out.Put(code.lengths[kLengthCodeOrder[k]], 3);
            out.Flush();
        }
        for (const Part& part : parts) {
            out.Put(code.codes[part.symbol], code.lengths[part.symbol]);
            out.Put(part.extra, part.extra_bits);
            out.Flush();
        }
    }
};

// How often each byte occurs; four tables, so that equal neighbours do not wait for each other.
class ByteCounts {
  public:
    void Add(const unsigned char* bytes, std::size_t count) {
        std::size_t i = 0;
        for (; i + 4 <= count; i += 4) {
            ++table_[0][bytes[i]];
            ++table_[1][bytes[i + 1]];
            ++table_[2][bytes[i + 2]];
            ++table_[3][bytes[i + 3]];
        }
        for (; i < count; ++i) ++table_[0][bytes[i]];
    }
    std::uint32_t of(std::size_t byte) const {
        return table_[0][byte] + table_[1][byte] + table_[2][byte] + table_[3][byte];
    }

  private:
    std::array<std::array<std::uint32_t, 256>, 4> table_{};
};

std::uint64_t Load64(const unsigned char* bytes) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes, 8);
    return word;
}

// How many bytes from bytes[at] on equal bytes[at - 1].
std::size_t RunLength(const unsigned char* bytes, std::size_t at, std::size_t end) {
    const std::uint64_t repeated = 0x0101010101010101u * bytes[at - 1];
    std::size_t i = at;
    for (; i + 8 <= end; i += 8) {
        const std::uint64_t differs = Load64(bytes + i) ^ repeated;
        if (differs != 0) {
            return i - at + static_cast<std::size_t>(std::countr_zero(differs)) / 8;
        }
    }
    while (i < end && bytes[i] == bytes[at - 1]) ++i;
    return i - at;
}

}  // namespace

void LineDeflater::FindRuns(const unsigned char* bytes, std::size_t begin, std::size_t end) {
    static_assert(kShortestRun == 8, "a run is seen in one word");
    std::size_t i = std::max<std::size_t>(begin, 1);
    while (i + kShortestRun <= end) {
        const std::uint64_t differs = Load64(bytes + i) ^ Load64(bytes + i - 1);
        if (differs != 0) {
            // No run begins at or before the last byte that differs.
            i += static_cast<std::size_t>(std::bit_width(differs) + 7) / 8;
            continue;
        }
        const std::size_t length = RunLength(bytes, i, end);
        copies_.push_back({i, length, 1});
        i += length;
    }
}

void LineDeflater::FindCopies(const unsigned char* bytes, std::size_t begin, std::size_t end,
                              std::size_t segment, std::size_t repeat) {
    copies_.clear();
    for (std::size_t at = begin; at < end; at += segment) {
        // The first byte differs: it is the step from another segment's last.
        const std::size_t rest = segment - 1;
        const unsigned char* first = bytes + at + 1;
        const bool may_repeat = repeat > 0 && repeat <= kWindow && repeat <= at;
        const bool repeats = may_repeat && rest >= kShortestCopy &&
                             std::memcmp(first, first - repeat, rest) == 0 &&
                             std::memcmp(first, first + 1, rest - 1) != 0;
        if (repeats) {
            copies_.push_back({at + 1, rest, repeat});
        } else {
            FindRuns(bytes, at, at + segment);
        }
    }
}

// One block (3.2.3) with codes of its own.
class LineDeflater::Block {
  public:
    Block(const unsigned char* bytes, std::size_t begin, std::size_t end,
          const std::vector<Copy>& copies)
        : bytes_(bytes), begin_(begin), end_(end), copies_(copies) {
        Count();
        literals_ = MakeHuffmanCode(literal_counts_, kLongestCode);
        std::vector<std::uint32_t> distance_counts = distance_counts_;
        // Not every reader takes a block in which no distance has a code.
        if (copies_.empty()) distance_counts[0] = 1;
        distances_ = MakeHuffmanCode(std::move(distance_counts), kLongestCode);
        lengths_.emplace(literals_, distances_);
    }

    std::uint64_t bits() const {
        return 3 + lengths_->bits + extra_bits_ + Cost(literal_counts_, literals_) +
               Cost(distance_counts_, distances_);
    }

    void Write(bool last, BitWriter& out) const {
        out.Put(last ? 1 : 0, 1);
        out.Put(2, 2);  // codes of its own
        lengths_->Write(out);
        std::size_t at = begin_;
        for (const Copy& copy : copies_) {
            WriteLiterals(at, copy.at, out);
            WriteCopy(copy, out);
            at = copy.at + copy.length;
        }
        WriteLiterals(at, end_, out);
        out.Put(literals_.codes[kEndOfBlock], literals_.lengths[kEndOfBlock]);
        out.Flush();
    }

  private:
    void Count() {
        ByteCounts bytes;
        std::size_t at = begin_;
        for (const Copy& copy : copies_) {
            bytes.Add(bytes_ + at, copy.at - at);
            at = copy.at + copy.length;
            const Part distance = DistancePart(copy.distance);
            ForEachPiece(copy.length, [&](std::size_t piece) {
                const Part length = LengthPart(piece);
                ++literal_counts_[length.symbol];
                ++distance_counts_[distance.symbol];
                extra_bits_ += std::uint64_t{length.extra_bits} + distance.extra_bits;
            });
        }
        bytes.Add(bytes_ + at, end_ - at);
        for (std::size_t byte = 0; byte < 256; ++byte) literal_counts_[byte] = bytes.of(byte);
        literal_counts_[kEndOfBlock] = 1;
    }

    void WriteLiterals(std::size_t begin, std::size_t end, BitWriter& out) const {
        const auto put = [&](std::size_t i) {
            out.Put(literals_.codes[bytes_[i]], literals_.lengths[bytes_[i]]);
        };
        std::size_t i = begin;
        for (; i + 4 <= end; i += 4) {
            put(i);
            put(i + 1);
            put(i + 2);
            put(i + 3);
            out.Flush();
        }
        for (; i < end; ++i) {
            put(i);
            out.Flush();
        }
    }

    void WriteCopy(const Copy& copy, BitWriter& out) const {
        const Part distance = DistancePart(copy.distance);
        ForEachPiece(copy.length, [&](std::size_t piece) {
            const Part length = LengthPart(piece);
            out.Put(literals_.codes[length.symbol], literals_.lengths[length.symbol]);
            out.Put(length.extra, length.extra_bits);
            out.Put(distances_.codes[distance.symbol], distances_.lengths[distance.symbol]);
            out.Put(distance.extra, distance.extra_bits);
            out.Flush();
        });
    }

    const unsigned char* bytes_;
    std::size_t begin_, end_;
    const std::vector<Copy>& copies_;
    std::vector<std::uint32_t> literal_counts_ = std::vector<std::uint32_t>(kLiteralSymbols, 0);
    std::vector<std::uint32_t> distance_counts_ = std::vector<std::uint32_t>(kDistanceSymbols, 0);
    std::uint64_t extra_bits_ = 0;
    HuffmanCode literals_, distances_;
    std::optional<LengthList> lengths_;
};

std::size_t LineDeflater::Deflate(const unsigned char* bytes, std::size_t count,
                                  std::size_t segment, std::size_t repeat, unsigned char* to,
                                  std::size_t room) {
    FLARE_CHECK(segment > 0 && count > 0 && count / 2 % segment == 0 && count % 2 == 0);
    constexpr std::size_t kFrame = 2 + 4;  // method in front, checksum behind (RFC 1950)
    if (room <= kFrame) return 0;
    to[0] = 0x78;
    to[1] = 0x01;
    BitWriter out(to + 2);
    const std::size_t most = std::max(kBlockBytes / segment, std::size_t{1}) * segment;
    std::uint64_t bits = 0;
    for (std::size_t begin = 0; begin < count;) {
        const std::size_t end = std::min(begin + most, begin < count / 2 ? count / 2 : count);
        FindCopies(bytes, begin, end, segment, repeat);
        const Block block(bytes, begin, end, copies_);
        bits += block.bits();
        if ((bits + 7) / 8 > room - kFrame) return 0;
        block.Write(end == count, out);
        begin = end;
    }
    out.PadToByte();
    out.Flush();
    const std::uint32_t sum = Adler32(bytes, count);
    unsigned char* end = out.end();
    for (int k = 3; k >= 0; --k) *end++ = static_cast<unsigned char>(sum >> (8 * k));
    return static_cast<std::size_t>(end - to);
}

std::uint32_t Adler32(const unsigned char* bytes, std::size_t count) {
    constexpr std::uint32_t kModulus = 65521;
    // Sums of a stretch stay within 32 bits, its weighted bytes within 16.
    constexpr std::size_t kStretch = 256;
    static constexpr auto kWeights = [] {
        std::array<std::uint16_t, kStretch> weights{};
        for (std::size_t i = 0; i < kStretch; ++i) {
            weights[i] = static_cast<std::uint16_t>(kStretch - i);
        }
        return weights;
    }();
    std::uint32_t a = 1, b = 0;
    std::size_t at = 0;
    for (; at + kStretch <= count; at += kStretch) {
        std::uint32_t sum = 0, weighted = 0;
        for (std::size_t i = 0; i < kStretch; ++i) {
            sum += bytes[at + i];
            weighted += static_cast<std::uint16_t>(bytes[at + i] * kWeights[i]);
        }
        b = (b + a * static_cast<std::uint32_t>(kStretch) + weighted) % kModulus;
        a = (a + sum) % kModulus;
    }
    for (; at < count; ++at) {
        a = (a + bytes[at]) % kModulus;
        b = (b + a) % kModulus;
    }
    return b << 16 | a;
}

}  // namespace flare
