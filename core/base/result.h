// SPDX-License-Identifier: Apache-2.0
//
// Result<T> is how a function says "here it is" or "your input was wrong, here": no exception
// crosses a layer. Reading the value of a failed result is a broken invariant and stops the
// program.
#pragma once

#include <string>
#include <utility>
#include <variant>

#include "core/base/check.h"

namespace flare {

// What was wrong with an input.
//   code     one stable word for programs: "bad_value", "unknown_field", "unsupported", ...
//   message  one sentence for people, naming the value and the limit it broke
//   where    the place in the input: a JSON pointer ("/lights/1/direction"), "line 4, column 9",
//            "byte 17"; "" for the whole
struct Error {
    std::string code;
    std::string message;
    std::string where;
};

template <class T>
class [[nodiscard]] Result {
  public:
    Result(T value) : state_(std::move(value)) {}      // NOLINT(google-explicit-constructor)
    Result(Error error) : state_(std::move(error)) {}  // NOLINT(google-explicit-constructor)

    bool ok() const { return std::holds_alternative<T>(state_); }
    explicit operator bool() const { return ok(); }

    const T& value() const {
        FLARE_CHECK(ok());
        return *std::get_if<T>(&state_);
    }
    T& value() {
        FLARE_CHECK(ok());
        return *std::get_if<T>(&state_);
    }
    const T& operator*() const { return value(); }
    T& operator*() { return value(); }
    const T* operator->() const { return &value(); }
    T* operator->() { return &value(); }

    const Error& error() const {
        FLARE_CHECK(!ok());
        return *std::get_if<Error>(&state_);
    }

  private:
    std::variant<T, Error> state_;
};

}  // namespace flare
