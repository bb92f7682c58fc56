// The instance that a block's methods are recording: what `now[...]`, `out[...]` and Count::value() talk to.

#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "engine/block.h"

namespace plantloop {

// Implemented by graph/; the newest one of a thread is in charge.
class BlockInstance {
 public:
  BlockInstance();
  virtual ~BlockInstance();
  BlockInstance(const BlockInstance&) = delete;
  BlockInstance& operator=(const BlockInstance&) = delete;
  static BlockInstance& current();

  virtual std::string_view path() = 0;
  virtual Array input(int index) = 0;
  virtual std::vector<Array> list(int index) = 0;
  virtual Array number(int index) = 0;
  virtual Array table(int index) = 0;
  virtual Array state(int index) = 0;
  virtual Array discrete(int index) = 0;
  virtual std::vector<Activity> activity(int list) = 0;
  virtual Value hit() = 0;
  virtual Value period() = 0;
  virtual Meeting meeting(int input) = 0;
  virtual Array earlier(int input, const Array& initial, bool steady) = 0;
  virtual bool connected(int input) = 0;
  virtual bool given_number(int index) = 0;
  virtual bool given_table(int index) = 0;
  virtual int count(int index) = 0;
  virtual std::string_view choice(int index) = 0;
  virtual std::string text(int index) = 0;
  virtual std::vector<Value> kernel(std::shared_ptr<const Kernel> kernel, std::vector<Value> inputs,
                                    std::vector<Value> advanced) = 0;
  virtual void write(Written what, int index, const Array& value) = 0;
  virtual int event(const Crossing& crossing) = 0;  // a number for the following calls
  virtual void jump(int event, bool discrete, int index, const Array& value) = 0;

 private:
  BlockInstance* previous_;
};

}  // namespace plantloop
