// Sums over the stages of a tableau, unrolled, without the terms that are zero.
#pragma once
#include <utility>

#include "tableaux.hpp"

template <class T, int S, class K, int... J>
inline double weighted(const K &k, int i, std::integer_sequence<int, J...>) {
  double sum = 0;
  bool first = true;
  (
      [&] {
        if constexpr (T::a[S][J] != 0) {
          sum = first ? T::a[S][J] * k[J][i] : sum + T::a[S][J] * k[J][i];
          first = false;
        }
      }(),
      ...);
  return sum;
}

template <class T, int R, class K, int... J>
inline double error_of(const K &k, int i, std::integer_sequence<int, J...>) {
  double sum = 0;
  ([&] { if constexpr (T::e[R][J] != 0) sum += T::e[R][J] * k[J][i]; }(), ...);
  return sum;
}
