// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>

#include "api/routes.hpp"
#include "http/accept.hpp"
#include "http/assembly.hpp"
#include "http/conditional.hpp"
#include "http/problem.hpp"
#include "platform/lists.hpp"
#include "web/assets.hpp"

namespace surfaced::api {
namespace {

using http::Request;
using http::Response;
using web::Asset;

/// The page loads nothing from elsewhere and is shown in no other page. The Draco decoder is WebAssembly.
constexpr std::string_view kPolicy =
    "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; style-src 'self'; "
    "img-src 'self' data: blob:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

const Asset* find_asset(std::string_view path) {
  const auto all = web::assets();
  const auto found = std::ranges::lower_bound(all, path, {}, &Asset::path);
  return found != all.end() && found->path == path ? &*found : nullptr;
}

/// True if Accept-Encoding names gzip and does not refuse it.
bool takes_gzip(const Request& request) {
  std::string_view list = request.headers.find("Accept-Encoding").value_or("");
  while (!list.empty()) {
    const std::string_view one = take_entry(list);
    const std::string_view name = one.substr(0, one.find_first_of("; "));
    if (!http::same_name(name, "gzip")) continue;
    constexpr auto kRefusals = std::to_array<std::string_view>({"q=0", "q=0.0", "q=0.00", "q=0.000"});
    const std::size_t weight = one.find("q=");
    return weight == one.npos || std::ranges::find(kRefusals, one.substr(weight)) == kRefusals.end();
  }
  return false;
}

Response asset_response(const Request& request, std::string_view path) {
  const Asset* const asset = find_asset(path);
  if (asset == nullptr) {
    return http::problem_response({ErrorCode::not_found, "there is nothing at '" + request.path + "'"}, request);
  }
  const bool compressed = !asset->gzip.empty() && takes_gzip(request);
  const std::string_view etag = compressed ? asset->etag_gzip : asset->etag;
  Response response;
  response.headers.add("ETag", std::string(etag));
  response.headers.add("Vary", "Accept-Encoding");
  response.headers.add("Cache-Control", asset->immutable ? "public, max-age=31536000, immutable" : "no-cache");
  if (http::not_modified(request.headers, etag)) {
    response.status = 304;
    return response;
  }
  response.headers.add("Content-Security-Policy", std::string(kPolicy));
  response.headers.add("Referrer-Policy", "no-referrer");
  if (compressed) response.headers.add("Content-Encoding", "gzip");
  response.content_type = asset->content_type;
  response.body = http::body_of_static(compressed ? asset->gzip : asset->bytes);
  return response;
}

http::Handler from(std::string folder) {
  return [folder = std::move(folder)](Request& request) {
    return asset_response(request, folder + request.path_parts.at("name"));
  };
}

/// A browser asks for HTML by name; whoever takes anything, as curl does, gets the links.
bool wants_page(const Request& request) {
  const auto ranges = http::parse_accept(request.headers.find("Accept").value_or("*/*"));
  return http::quality_of(ranges, "text/html") > http::quality_of(ranges, "application/json");
}

}  // namespace

void add_viewer_routes(http::Router& router, http::Handler index) {
  router.add("GET", "/", [index = std::move(index)](Request& request) {
    const bool page = wants_page(request) && find_asset("index.html") != nullptr;
    Response response = page ? asset_response(request, "index.html") : index(request);
    response.headers.set("Vary", "Accept, Accept-Encoding");
    return response;
  });
  router.add("GET", "/assets/{name}", from("assets/"));
  router.add("GET", "/samples", [](Request& request) { return asset_response(request, "samples/samples.json"); });
  router.add("GET", "/samples/{name}", from("samples/"));
  router.add("GET", "/licenses", [](Request& request) { return asset_response(request, "licenses.html"); });
}

}  // namespace surfaced::api
