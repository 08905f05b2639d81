// Who may connect to the studio.
#include "host/studio/access.h"

#include <set>
#include <string>

#include <gtest/gtest.h>

namespace fascicle::tests {
namespace {

using studio::is_own_host;
using studio::is_own_origin;
using studio::is_token;
using studio::parse_target;

TEST(Access, TokensAreNewAndCompareWhole) {
  std::set<std::string> tokens;
  for (int k = 0; k < 100; ++k) {
    const std::string token = studio::new_token();
    EXPECT_EQ(token.size(), 32u);
    EXPECT_EQ(token.find_first_not_of("0123456789abcdef"), std::string::npos);
    tokens.insert(token);
  }
  EXPECT_EQ(tokens.size(), 100u);
  EXPECT_TRUE(is_token("abc", "abc"));
  EXPECT_FALSE(is_token("abd", "abc"));
  EXPECT_FALSE(is_token("ab", "abc"));
  EXPECT_FALSE(is_token("abcd", "abc"));
  EXPECT_FALSE(is_token("", ""));
}

TEST(Access, OnlyItsOwnNamesAreItsHost) {
  EXPECT_TRUE(is_own_host("127.0.0.1:8080", 8080));
  EXPECT_TRUE(is_own_host("localhost:8080", 8080));
  for (const char* host : {"", "127.0.0.1", "127.0.0.1:80", "127.0.0.1:80800", "evil.example:8080",
                           "localhost.evil:8080", "127.0.0.2:8080", "0.0.0.0:8080", "127.0.0.1:8080.evil"})
    EXPECT_FALSE(is_own_host(host, 8080)) << host;
  EXPECT_TRUE(is_own_origin("http://127.0.0.1:8080", 8080));
  for (const char* origin : {"", "null", "https://127.0.0.1:8080", "http://evil.example",
                             "http://127.0.0.1:8081", "http://127.0.0.1:8080/", "http://evil.example:8080"})
    EXPECT_FALSE(is_own_origin(origin, 8080)) << origin;
}

TEST(Access, TargetsArePlainNames) {
  ASSERT_TRUE(parse_target("/"));
  EXPECT_EQ(parse_target("/")->path, "");
  EXPECT_EQ(parse_target("/studio.js")->path, "studio.js");
  EXPECT_FALSE(parse_target("/studio.js")->token);
  EXPECT_EQ(parse_target("/live?token=abc")->token, "abc");
  EXPECT_FALSE(parse_target("/live?key=abc")->token);
  for (const char* target : {"", "live", "/../etc/passwd", "/..", "/a/b", "//etc/passwd", "/%2e%2e/x",
                             "/a\\b", "http://127.0.0.1/"})
    EXPECT_FALSE(parse_target(target)) << target;
}

}  // namespace
}  // namespace fascicle::tests
