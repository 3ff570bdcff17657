#include "firmware/transport/address.h"

#include <gtest/gtest.h>

namespace stria {
namespace {

TEST(Address, ReadsWhatItWrites) {
    for (const char* text : {"unix:/run/stria/a.sock", "tcp:127.0.0.1:7700", "tcp:::1:0"}) {
        const auto address = parse_address(text);
        ASSERT_TRUE(address) << text;
        EXPECT_EQ(to_string(*address), text);
    }
    EXPECT_EQ(parse_address("tcp:localhost:1")->host, "127.0.0.1");
}

TEST(Address, RefusesOtherComputers) {
    for (const char* text : {"tcp:0.0.0.0:7700", "tcp:192.168.1.4:7700", "tcp:example.org:1"}) {
        const auto address = parse_address(text);
        ASSERT_FALSE(address) << text;
        EXPECT_NE(address.failure().message.find("keys"), std::string::npos);
    }
}

TEST(Address, SaysWhatIsWrongAndShowsARightOne) {
    const std::string long_path = "unix:/" + std::string(107, 'x');
    for (const std::string& text :
         {std::string(""), std::string("usb:"), std::string("unix:"), std::string("tcp:127.0.0.1"),
          std::string("tcp:127.0.0.1:"), std::string("tcp:127.0.0.1:70000"),
          std::string("tcp:127.0.0.1:12x"), long_path}) {
        const auto address = parse_address(text);
        ASSERT_FALSE(address) << text;
        EXPECT_NE(address.failure().message.find("tcp:127.0.0.1:7700"), std::string::npos);
    }
}

}  // namespace
}  // namespace stria
