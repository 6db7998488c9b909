//! Pixels of a finished picture on their way from the GPU, without waiting for them.

use std::sync::{Arc, Mutex, PoisonError};

use image::RgbaImage;

use super::Target;

/// Whether the pixels have arrived, or why they will not.
type Arrival = Arc<Mutex<Option<Result<(), wgpu::BufferAsyncError>>>>;

/// A picture on its way.
pub struct Readback {
    buffer: wgpu::Buffer,
    size: [u32; 2],
    /// Bytes from one row to the next in the buffer.
    padded: usize,
    arrival: Arrival,
}

impl Readback {
    /// Asks for the pixels of a target; `when_done` is called once, from [`Self::take`] or from the browser.
    pub fn start(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        target: &Target,
        when_done: impl FnOnce() + wgpu::WasmNotSend + 'static,
    ) -> Self {
        let size = target.size();
        let [width, height] = size;
        let padded = (width as usize * 4).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT as usize);
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("read back"),
            size: padded as u64 * u64::from(height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(padded as u32), rows_per_image: None };
        encoder.copy_texture_to_buffer(
            target.color_texture().as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer: &buffer, layout },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
        queue.submit([encoder.finish()]);
        let arrival = Arrival::default();
        let there = arrival.clone();
        buffer.map_async(wgpu::MapMode::Read, .., move |result| {
            *there.lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
            when_done();
        });
        Self { buffer, size, padded, arrival }
    }

    /// The picture with straight alpha, as PNG wants it, once it is there; call it again until it is.
    ///
    /// The error is what wgpu says when the device is lost.
    pub fn take(&self, device: &wgpu::Device) -> Option<Result<RgbaImage, String>> {
        // In the browser with WebGPU this does nothing, and the browser itself calls back.
        if let Err(error) = device.poll(wgpu::PollType::Poll) {
            return Some(Err(error.to_string()));
        }
        let arrived = self.arrival.lock().unwrap_or_else(PoisonError::into_inner).take()?;
        Some(arrived.map_err(|error| error.to_string()).and_then(|()| self.picture()))
    }

    fn picture(&self) -> Result<RgbaImage, String> {
        let [width, height] = self.size;
        let row = width as usize * 4;
        let mapped = self.buffer.get_mapped_range(..).map_err(|error| error.to_string())?;
        let mut pixels = Vec::with_capacity(row * height as usize);
        for line in mapped.chunks_exact(self.padded) {
            pixels.extend_from_slice(&line[..row]);
        }
        pixels.chunks_exact_mut(4).for_each(straighten);
        RgbaImage::from_raw(width, height, pixels).ok_or_else(|| "wrong number of bytes".to_owned())
    }
}

/// Straight alpha from premultiplied.
fn straighten(pixel: &mut [u8]) {
    let [color @ .., alpha] = pixel else { return };
    if !matches!(alpha, 0 | 255) {
        for channel in color {
            *channel = ((u32::from(*channel) * 255 + u32::from(*alpha) / 2) / u32::from(*alpha)).min(255) as u8;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::straighten;

    #[test]
    fn alpha_becomes_straight_and_clear_pixels_stay_clear() {
        let straight = |mut pixel: [u8; 4]| {
            straighten(&mut pixel);
            pixel
        };
        assert_eq!(straight([64, 32, 0, 128]), [128, 64, 0, 128]);
        assert_eq!(straight([10, 20, 30, 255]), [10, 20, 30, 255]);
        assert_eq!(straight([0, 0, 0, 0]), [0; 4]);
        assert_eq!(straight([200, 200, 200, 100]), [255, 255, 255, 100], "rounding never overflows");
    }
}
