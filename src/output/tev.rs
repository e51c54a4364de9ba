//! The tev image viewer (github.com/Tom94/tev): tiles sent as they are finished.
//!
//! A message is its length in bytes, that included, as a little-endian u32, its kind, and its fields: numbers
//! little-endian, text with a zero behind it. Two kinds are needed: an image is made, and a part of it gets new values,
//! each channel with its offset and stride among the floats that follow ("create image", "update image" version 3).

use crate::error::{Error, Result};
use crate::film::Film;
use crate::tile::Tile;
use std::io::{self, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

const CREATE_IMAGE: u8 = 4;
const UPDATE_IMAGE_V3: u8 = 6;
const CHANNELS: [&str; 3] = ["R", "G", "B"];
/// Nobody waits longer than this for a viewer.
const PATIENCE: Duration = Duration::from_secs(5);

/// An image in a viewer.
#[derive(Debug)]
pub struct Tev {
    stream: TcpStream,
    name: String,
    /// The message being made.
    message: Vec<u8>,
}

impl Tev {
    /// Makes an image of this size in the viewer at `address` (HOST:PORT).
    ///
    /// # Errors
    /// [`Error::Flag`] if there is no viewer.
    pub fn connect(address: &str, name: &str, [width, height]: [u32; 2]) -> Result<Tev> {
        let refused = |error: io::Error| {
            let remedy = "start tev there first, or leave it out; it listens at 127.0.0.1:14158";
            Error::flag("--tev", format!("{address} cannot be reached ({error})"), remedy)
        };
        let mut found = address.to_socket_addrs().map_err(refused)?;
        let place = found.next().ok_or_else(|| refused(io::ErrorKind::NotFound.into()))?;
        let stream = TcpStream::connect_timeout(&place, PATIENCE).map_err(refused)?;
        stream.set_write_timeout(Some(PATIENCE)).map_err(refused)?;
        let mut tev = Tev { stream, name: name.replace('\0', ""), message: Vec::new() };
        tev.begin(CREATE_IMAGE);
        tev.number(width);
        tev.number(height);
        tev.channels();
        tev.send().map_err(refused)?;
        Ok(tev)
    }

    /// Sends the pixels of `tile`.
    ///
    /// # Errors
    /// Whatever the connection says: the viewer was closed.
    pub fn update(&mut self, tile: Tile, film: &Film) -> io::Result<()> {
        self.begin(UPDATE_IMAGE_V3);
        self.channels();
        for number in [tile.x, tile.y, tile.width, tile.height] {
            self.number(number);
        }
        let channels = CHANNELS.len() as i64;
        let (offsets, strides) = ((0..channels), (0..channels).map(|_| channels));
        let places: Vec<u8> = offsets.chain(strides).flat_map(i64::to_le_bytes).collect();
        self.message.extend(places);
        for y in tile.y..tile.y + tile.height {
            let row = film.row(y).skip(tile.x as usize).take(tile.width as usize);
            self.message.extend(row.flatten().flat_map(f32::to_le_bytes));
        }
        self.send()
    }

    /// Length (filled in later), kind, whether the viewer comes to the front, name.
    fn begin(&mut self, kind: u8) {
        self.message.clear();
        self.message.extend([0, 0, 0, 0, kind, u8::from(kind == CREATE_IMAGE)]);
        self.message.extend(self.name.as_bytes());
        self.message.push(0);
    }

    fn number(&mut self, number: u32) {
        self.message.extend(number.to_le_bytes());
    }

    fn channels(&mut self) {
        self.number(CHANNELS.len() as u32);
        for name in CHANNELS {
            self.message.extend(name.as_bytes());
            self.message.push(0);
        }
    }

    fn send(&mut self) -> io::Result<()> {
        let length = (self.message.len() as u32).to_le_bytes();
        self.message[..4].copy_from_slice(&length);
        self.stream.write_all(&self.message)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;
    use std::net::TcpListener;

    /// A viewer that understands what irt sends, read field by field as tev's own source does.
    struct Viewer {
        bytes: Vec<u8>,
        at: usize,
    }

    impl Viewer {
        fn take<const N: usize>(&mut self) -> [u8; N] {
            self.at += N;
            self.bytes[self.at - N..self.at].try_into().unwrap()
        }
        fn number(&mut self) -> i32 {
            i32::from_le_bytes(self.take())
        }
        fn text(&mut self) -> String {
            let end = self.bytes[self.at..].iter().position(|&byte| byte == 0).unwrap();
            let text = String::from_utf8(self.bytes[self.at..self.at + end].to_vec()).unwrap();
            self.at += end + 1;
            text
        }
        fn channels(&mut self) -> Vec<String> {
            (0..self.number()).map(|_| self.text()).collect()
        }
    }

    #[test]
    fn a_viewer_gets_the_image_and_every_pixel_of_its_tiles() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap().to_string();
        let receiver = std::thread::spawn(move || {
            let mut bytes = vec![];
            listener.accept().unwrap().0.read_to_end(&mut bytes).unwrap();
            bytes
        });
        let film = Film::new(7, 5);
        let plane = |c: f32| (0..35).map(|i| i as f32 + c).collect::<Vec<f32>>();
        film.write_tile(Tile { x: 0, y: 0, width: 7, height: 5 }, &plane(0.0), &plane(0.25), &plane(0.5));
        let tiles = [Tile { x: 0, y: 0, width: 4, height: 5 }, Tile { x: 4, y: 0, width: 3, height: 5 }];
        let mut tev = Tev::connect(&address, "a scene", [7, 5]).unwrap();
        tiles.into_iter().for_each(|tile| tev.update(tile, &film).unwrap());
        drop(tev);

        let mut viewer = Viewer { bytes: receiver.join().unwrap(), at: 0 };
        let mut image = vec![[f32::NAN; 3]; 35];
        let mut kinds = vec![];
        while viewer.at < viewer.bytes.len() {
            let end = viewer.at + viewer.number() as usize;
            let [kind, _front] = viewer.take();
            kinds.push(kind);
            assert_eq!(viewer.text(), "a scene");
            if kind == CREATE_IMAGE {
                assert_eq!([viewer.number(), viewer.number()], [7, 5]);
                assert_eq!(viewer.channels(), ["R", "G", "B"]);
            } else {
                assert_eq!(viewer.channels().len(), 3);
                let [x, y, width, height] = [(); 4].map(|()| viewer.number() as usize);
                let [offsets, strides] =
                    [(); 2].map(|()| [(); 3].map(|()| i64::from_le_bytes(viewer.take()) as usize));
                let floats: Vec<f32> =
                    (viewer.at..end).step_by(4).map(|_| f32::from_le_bytes(viewer.take())).collect();
                for i in 0..width * height {
                    let pixel = &mut image[(y + i / width) * 7 + x + i % width];
                    *pixel = [0, 1, 2].map(|c| floats[offsets[c] + strides[c] * i]);
                }
            }
            assert_eq!(viewer.at, end, "the length is that of the message");
        }
        assert_eq!(kinds, [CREATE_IMAGE, UPDATE_IMAGE_V3, UPDATE_IMAGE_V3]);
        assert!(image.into_iter().eq(film.pixels()));
    }

    #[test]
    fn where_no_viewer_is_the_flag_is_named() {
        let free = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
        for address in [free.as_str(), "nonsense"] {
            let message = Tev::connect(address, "x", [1, 1]).unwrap_err().to_string();
            assert!(message.starts_with("--tev: ") && message.contains("start tev"), "{message}");
        }
    }
}
