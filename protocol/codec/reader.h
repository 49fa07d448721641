// SPDX-License-Identifier: Apache-2.0
//
// The small words in which the decoders are written. Every function returns false after it has put
// down the first refusal, so decoders read as one chain of &&.
#pragma once

#include <array>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/codec/json_document.h"
#include "protocol/wire/refusal.h"

namespace flare::wire {

// What a number may be. Above `max` the refusal is "limit" if the bound is one of ours
// (protocol/limits.h) and "bad_value" if it lies in the thing itself.
struct Range {
    double min = -std::numeric_limits<double>::infinity();
    double max = std::numeric_limits<double>::infinity();
    bool min_excluded = false;
    bool max_is_limit = false;
};
constexpr Range Between(double min, double max) {
    return {min, max, false, false};
}
constexpr Range FromUpTo(double min, double limit) {
    return {min, limit, false, true};
}
constexpr Range AboveZeroUpTo(double limit) {
    return {0.0, limit, true, true};
}
constexpr Range Within(double limit) {
    return {-limit, limit, false, true};
}

template <class T>
struct Word {
    std::string_view name;
    T value;
};

class Reader {
  public:
    const Refusal& refusal() const { return refusal_; }

    bool Refuse(const JsonView& at, std::string code, std::string message);
    bool RefuseMember(const JsonView& object, std::string_view member, std::string code,
                      std::string message);
    bool Unsupported(const JsonView& at);

    // An object with no members but those of `known`. Members of `later` belong to the contract and
    // are not built yet.
    bool Object(const JsonView& at, std::initializer_list<std::string_view> known,
                std::initializer_list<std::string_view> later = {});
    // The member `name` of an object that must be there.
    bool Require(const JsonView& object, std::string_view name, std::optional<JsonView>& member);

    bool Boolean(const JsonView& at, bool& value);
    bool Number(const JsonView& at, Range range, double& value);
    bool Integer(const JsonView& at, int min, int limit, int& value);
    bool Text(const JsonView& at, std::size_t limit, std::string& value);
    // An array of at most `limit` elements.
    bool Array(const JsonView& at, std::size_t limit);
    // An array of exactly `count` elements.
    bool Tuple(const JsonView& at, std::size_t count);

    template <std::size_t N>
    bool Numbers(const JsonView& at, Range range, std::array<double, N>& values) {
        if (!Tuple(at, N)) return false;
        std::size_t i = 0;
        for (auto child = at.FirstChild(); child; child = child->NextSibling()) {
            if (!Number(*child, range, values[i++])) return false;
        }
        return true;
    }

    template <std::size_t N>
    bool Integers(const JsonView& at, int min, int limit, std::array<int, N>& values) {
        if (!Tuple(at, N)) return false;
        std::size_t i = 0;
        for (auto child = at.FirstChild(); child; child = child->NextSibling()) {
            if (!Integer(*child, min, limit, values[i++])) return false;
        }
        return true;
    }

    // One word of a list; a word of `later` is part of the contract and not built yet.
    template <class T>
    bool OneOf(const JsonView& at, std::initializer_list<Word<T>> words, T& value,
               std::initializer_list<std::string_view> later = {}) {
        if (!IsText(at)) return false;
        std::string choices;
        for (const Word<T>& word : words) {
            if (word.name == at.string()) {
                value = word.value;
                return true;
            }
            choices += (choices.empty() ? "\"" : ", \"") + std::string(word.name) + "\"";
        }
        for (const std::string_view word : later) {
            if (word == at.string()) return Unsupported(at);
        }
        return Refuse(at, "bad_value", Quoted(at) + " is not one of " + choices);
    }

  private:
    bool IsText(const JsonView& at);
    bool WrongType(const JsonView& at, std::string_view expected);
    static std::string Quoted(const JsonView& text);

    Refusal refusal_;
};

// Decodes an optional member: nothing to do if it is not there.
template <class Decode>
bool IfGiven(const JsonView& object, std::string_view name, Decode&& decode) {
    const std::optional<JsonView> member = object.Find(name);
    return !member || decode(*member);
}

}  // namespace flare::wire
