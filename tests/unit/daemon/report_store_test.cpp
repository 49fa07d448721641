// SPDX-License-Identifier: Apache-2.0
#include "server/report_store.h"

#include <gtest/gtest.h>

#include <set>

namespace flare {
namespace {

TEST(ReportStore, KeepsTheLastOnes) {
    ReportStore store;
    std::vector<std::string> ids;
    for (std::size_t i = 0; i < ReportStore::kKept + 3; ++i) {
        ids.push_back(store.NewId());
        store.Put(ids.back(), "report " + std::to_string(i));
    }
    EXPECT_EQ(store.Get(ids[2]), std::nullopt);
    EXPECT_EQ(store.Get(ids[3]), "report 3");
    EXPECT_EQ(store.Get(ids.back()), "report " + std::to_string(ReportStore::kKept + 2));
    EXPECT_EQ(std::set<std::string>(ids.begin(), ids.end()).size(), ids.size());
}

}  // namespace
}  // namespace flare
