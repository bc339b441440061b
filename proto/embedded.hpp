// SPDX-License-Identifier: GPL-3.0-or-later
// The contract as bytes inside the binary.
#pragma once

#include <string_view>

namespace surfaced::proto {

/// proto/errors.json.
std::string_view errors_json();
/// proto/openapi.yaml with the schemas, as JSON.
std::string_view openapi_json();

/// The same in OpenAPI 3.0.
std::string_view openapi30_json();
/// proto/docs.html: shows the contract to people.
std::string_view docs_html();
/// Style and script of that page, which has neither inside.
std::string_view docs_css();
std::string_view docs_js();

}  // namespace surfaced::proto
